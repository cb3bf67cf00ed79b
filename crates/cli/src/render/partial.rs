//! `OUT.partial.exr`: what there is of a render that is not finished.

use std::path::{Path, PathBuf};

use anyhow::Result;
use stack::file::extension;

use crate::failure::usage;
use crate::output::Outputs;
use crate::progress::Progress;

/// Where an interrupted run leaves what it has: beside the first .exr output, else beside the first output.
pub fn partial_path(outputs: &Outputs) -> PathBuf {
    let files = outputs.files();
    let named = files.iter().find(|file| extension(file) == "exr").or(files.first());
    named.map_or_else(|| PathBuf::from("picture.partial.exr"), |file| file.with_extension("partial.exr"))
}

/// Refuses to begin where an interrupted run has left samples in `file`, which the next interruption would replace.
///
/// # Errors
/// When the file is there.
pub fn refuse_to_lose(file: &Path) -> Result<()> {
    if !file.exists() {
        return Ok(());
    }
    let file = file.display();
    Err(usage(format!(
        "{file} keeps the samples of a render that was interrupted: --resume goes on with it, or delete it"
    )))
}

/// Removes what was kept of a render that is finished.
pub fn clear_away(file: &Path, progress: &Progress) {
    if let Err(error) = std::fs::remove_file(file) {
        progress.say(&format!("{} is of no more use, but cannot be removed: {error}", file.display()));
    }
}
