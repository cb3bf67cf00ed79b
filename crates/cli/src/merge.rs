//! `tamis merge`: adds up renders of the same picture with different samples.

use anyhow::Result;
use clap::ArgMatches;
use stack::file::Inputs;

use crate::args::{DenoiseArgs, MergeArgs};
use crate::denoise;
use crate::failure::{Verdict, usage};

/// Runs the command: what the slices are together is reconstructed as any other stack.
pub fn run(args: &MergeArgs, matches: &ArgMatches) -> Result<Verdict> {
    let MergeArgs { slices, max_memory, picture, output, report } = args;
    if output.output.is_empty() {
        return Err(usage("merge needs an output file: -o FILE"));
    }
    let denoise = DenoiseArgs {
        max_memory: *max_memory,
        picture: picture.clone(),
        output: output.clone(),
        report: report.clone(),
        ..DenoiseArgs::default()
    };
    denoise::run_one(&denoise, matches, Inputs::Slices(slices.clone()))
}
