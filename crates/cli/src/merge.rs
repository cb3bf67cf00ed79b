//! `tamis merge`: adds up renders of the same picture with different samples.

use anyhow::Result;
use clap::ArgMatches;
use stack::file::Inputs;

use crate::args::MergeArgs;
use crate::denoise::{self, Task, Wishes};
use crate::failure::{Verdict, usage};
use crate::spool::Spool;

/// Runs the command: what the slices are together is reconstructed as any other stack.
pub fn run(args: &MergeArgs, matches: &ArgMatches) -> Result<Verdict> {
    let MergeArgs { slices, rebuild } = args;
    if rebuild.output.output.is_empty() {
        return Err(usage("merge needs an output file: -o FILE"));
    }
    let mut spool = Spool::default();
    let inputs = Inputs::Slices(slices.iter().map(|slice| spool.path(slice)).collect::<Result<_>>()?);
    let task = Task { rebuild, matches, inputs, output: rebuild.output.clone(), wishes: Wishes::default() };
    spool.naming(denoise::run_one(task))
}
