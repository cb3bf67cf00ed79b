//! Open Image Denoise beside us: an outside program that turns a stack into pictures.

use std::path::Path;
use std::process::Command;

use anyhow::Result;
use stack::Image;
use stack::file::read_picture;

use crate::failure::usage;

/// Its pictures, with features as they are and with features denoised first.
pub const NAMES: [&str; 2] = ["oidn", "oidn-clean"];

/// Runs `command STACK -o FOLDER` and reads what it wrote: STACK-oidn.exr and STACK-oidn-clean.exr in `folder`.
///
/// # Errors
/// When the program cannot be started, fails, or leaves a picture out.
pub fn denoise(command: &str, stack: &Path, folder: &Path) -> Result<Vec<(&'static str, Image)>> {
    let mut words = command.split_whitespace();
    let program = words.next().ok_or_else(|| usage("--oidn: expected a command"))?;
    let outcome = Command::new(program).args(words).arg(stack).arg("-o").arg(folder).output();
    let outcome = outcome.map_err(|error| usage(format!("--oidn: cannot start {program}: {error}")))?;
    if !outcome.status.success() {
        let said = String::from_utf8_lossy(&outcome.stderr);
        return Err(usage(format!("--oidn: {program} failed: {}", said.lines().last().unwrap_or("without a word"))));
    }
    let stem = stack.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    NAMES.iter().map(|name| Ok((*name, read_picture(&folder.join(format!("{stem}-{name}.exr")))?))).collect()
}
