//! How much a file may ask for.

use std::path::Path;

use super::FileError;
use super::memory_limit::memory_limit;

/// What is assumed where the system does not say how much memory is free.
const ASSUMED: u64 = 16 << 30;

/// Refuses a picture that would not fit into memory, before any of it is allocated.
///
/// # Errors
/// When `pixels` × `bytes` a pixel is more than there is.
pub fn check_fits(path: &Path, (width, height): (usize, usize), bytes: usize) -> Result<(), FileError> {
    let needed = width as u128 * height as u128 * bytes as u128;
    let available = available();
    if needed <= u128::from(available) {
        return Ok(());
    }
    Err(FileError::TooLarge { path: path.into(), width, height, needed, available })
}

/// Bytes that can be had without swapping, and within the limit of a container.
fn available() -> u64 {
    let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"));
    let kilobytes = line.and_then(|rest| rest.split_whitespace().next()?.parse::<u64>().ok());
    let free = kilobytes.map_or(ASSUMED, |kilobytes| kilobytes.saturating_mul(1024));
    memory_limit().map_or(free, |limit| limit.min(free))
}
