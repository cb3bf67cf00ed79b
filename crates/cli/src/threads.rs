//! How many threads work.

use anyhow::{Context, Result};

use crate::args::ReportArgs;

/// Starts the worker threads that were asked for.
///
/// # Errors
/// When the machine refuses them.
pub fn start_threads(report: &ReportArgs) -> Result<()> {
    if let Some(threads) = report.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(threads))
            .build_global()
            .context("cannot start the worker threads")?;
    }
    Ok(())
}
