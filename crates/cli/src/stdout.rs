//! Standard output, which may be closed early by whoever reads it.

use std::io::{ErrorKind, Write};

use anyhow::{Context, Result};

/// Prints `text` and a line end. A reader that has gone away (`| head`) is no error.
///
/// # Errors
/// When standard output cannot be written for another reason.
pub fn print_line(text: impl std::fmt::Display) -> Result<()> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("cannot write to standard output"),
        _ => Ok(()),
    }
}
