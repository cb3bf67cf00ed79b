//! A file that keeps what is said on standard error, whether it is said there or not.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::{Mutex, OnceLock};
use std::time::Instant;

use anyhow::{Context, Result};

/// The file of this process, and when it was opened.
static LOG: OnceLock<Log> = OnceLock::new();

struct Log {
    file: Mutex<File>,
    start: Instant,
}

/// Opens the file at `path` for all that is said from now on; what it holds is kept.
///
/// # Errors
/// When it cannot be written.
pub fn open(path: &Path) -> Result<()> {
    let file = File::options().create(true).append(true).open(path);
    let file = file.with_context(|| format!("--log-file {}: cannot be written", path.display()))?;
    LOG.get_or_init(|| Log { file: Mutex::new(file), start: Instant::now() });
    let words: Vec<String> = std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
    add(&words.join(" "));
    Ok(())
}

/// Adds a line, if there is a file. One that is full or gone is no reason to stop.
pub fn add(line: &str) {
    let Some(Log { file, start }) = LOG.get() else { return };
    if let Ok(mut file) = file.lock() {
        let _ = writeln!(file, "{:9.1} s  {line}", start.elapsed().as_secs_f64());
    }
}
