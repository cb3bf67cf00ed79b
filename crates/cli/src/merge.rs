//! `tamis merge`: adds up renders of the same picture with different samples.

use anyhow::Result;
use clap::ArgMatches;
use stack::file::Inputs;

use crate::args::MergeArgs;
use crate::denoise::{self, Task, Wishes};
use crate::failure::{Verdict, usage};

/// Runs the command: what the slices are together is reconstructed as any other stack.
pub fn run(args: &MergeArgs, matches: &ArgMatches) -> Result<Verdict> {
    let MergeArgs { slices, rebuild } = args;
    if rebuild.output.output.is_empty() {
        return Err(usage("merge needs an output file: -o FILE"));
    }
    let inputs = Inputs::Slices(slices.clone());
    denoise::run_one(Task { rebuild, matches, inputs, output: rebuild.output.clone(), wishes: Wishes::default() })
}
