//! `tamis denoise`: reconstructs existing stacks.

mod batch;
mod empty_pixels;
mod task;

use anyhow::Result;
use clap::ArgMatches;
use stack::file::{Inputs, Source};

use crate::args::DenoiseArgs;
use crate::failure::{Verdict, usage};
use crate::interrupt;
use crate::progress::Progress;
use crate::spool::Spool;
use crate::stdout::print_line;
use crate::threads::start_threads;
pub use task::{Task, Wishes};

/// Runs the command.
pub fn run(mut args: DenoiseArgs, matches: &ArgMatches) -> Result<Verdict> {
    if args.rebuild.output.output.is_empty() {
        return Err(usage("denoise needs an output file: -o FILE"));
    }
    let mut spool = Spool::default();
    store_pipes(&mut args, &mut spool)?;
    spool.naming(run_on_files(&args, matches, &spool))
}

/// Puts files in the place of inputs that can be read only once.
fn store_pipes(args: &mut DenoiseArgs, spool: &mut Spool) -> Result<()> {
    for text in &mut args.input {
        *text = spool.text(text)?;
    }
    let halves = [&mut args.half_a, &mut args.half_b, &mut args.guide];
    for path in halves.into_iter().flatten().chain(&mut args.buckets) {
        *path = spool.path(path)?;
    }
    Ok(())
}

fn run_on_files(args: &DenoiseArgs, matches: &ArgMatches, spool: &Spool) -> Result<Verdict> {
    let files = args.input.iter().map(|text| Source::parse(text).path);
    if let Some(folder) = files.into_iter().find(|file| file.is_dir()) {
        let folder = folder.display();
        return Err(usage(format!("{folder}: expected files, found a folder; name them, as {folder}/*.exr does")));
    }
    let renders = args.half_a.iter().chain(&args.half_b).chain(&args.buckets);
    if let Some(pattern) = renders.into_iter().find(|path| batch::is_pattern(path)) {
        return Err(usage(format!("{}: only INPUT may have #### for the numbers of frames", pattern.display())));
    }
    if let Some(jobs) = batch::jobs(args)? {
        if let Some(pipe) = spool.first_name() {
            return Err(usage(format!("{pipe} has no name to be written under: give a file as output")));
        }
        if args.guide.is_some() {
            return Err(usage("--guide is one picture: denoise one stack at a time"));
        }
        return batch::run(args, matches, &jobs);
    }
    if args.resume {
        return Err(usage("--resume leaves out some of several pictures, and this is one: leave it out"));
    }
    let (rebuild, output) = (&args.rebuild, args.rebuild.output.clone());
    let guide = args.guide.as_deref().map(|file| (file, spool.name_of(file)));
    run_one(Task { rebuild, matches, inputs: inputs(args), output, wishes: Wishes { guide, ..Wishes::of(args) } })
}

/// Reconstructs the one stack of `task`.
///
/// # Errors
/// When a step fails.
pub fn run_one(task: Task<'_>) -> Result<Verdict> {
    let outputs = task.prepare()?;
    let said = &task.rebuild.report;
    start_threads(said)?;
    interrupt::listen();
    let report = task.run(&outputs, &Progress::new(said))?;
    if said.json {
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
