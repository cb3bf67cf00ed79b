//! `tamis denoise`: reconstructs existing stacks.

mod batch;
mod task;

use anyhow::Result;
use clap::ArgMatches;
use stack::file::{Inputs, Source};

use crate::args::DenoiseArgs;
use crate::failure::{Verdict, usage};
use crate::interrupt;
use crate::progress::Progress;
use crate::stdout::print_line;
use crate::threads::start_threads;
use task::Task;

/// Runs the command.
pub fn run(args: &DenoiseArgs, matches: &ArgMatches) -> Result<Verdict> {
    if args.output.output.is_empty() {
        return Err(usage("denoise needs an output file: -o FILE"));
    }
    if let Some(jobs) = batch::jobs(args)? {
        if args.guide.is_some() {
            return Err(usage("--guide is one picture: denoise one stack at a time"));
        }
        return batch::run(args, matches, &jobs);
    }
    run_one(args, matches, inputs(args))
}

/// Reconstructs the one stack in `inputs`.
///
/// # Errors
/// When a step fails.
pub fn run_one(args: &DenoiseArgs, matches: &ArgMatches, inputs: Inputs) -> Result<Verdict> {
    let task = Task { args, matches, inputs, output: args.output.clone() };
    let outputs = task.prepare()?;
    start_threads(&args.report)?;
    interrupt::listen();
    let report = task.run(&outputs, &Progress::new(&args.report))?;
    if args.report.json {
        print_line(report)?;
    }
    Ok(Verdict::Done)
}

/// The files of one stack, as the flags say.
fn inputs(args: &DenoiseArgs) -> Inputs {
    let files = args.input.iter().map(|text| Source::parse(text)).collect();
    match (&args.half_a, &args.half_b) {
        (Some(a), Some(b)) => Inputs::Halves([a.clone(), b.clone()], files),
        _ if !args.buckets.is_empty() => Inputs::Buckets(args.buckets.clone()),
        _ => Inputs::Files(files),
    }
}
