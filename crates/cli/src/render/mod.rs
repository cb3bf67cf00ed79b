//! `tamis render`: from a scene to a picture that knows its own error.

mod adaptive_loop;
mod checkpoint;
mod plan;
mod record;
mod report;
mod resume;
mod tev;
mod time_left;
mod view;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use clap::ArgMatches;
use serde_json::Value;
use stack::file::{Carried, StackHeader, extension};
use stack::{FeatureStack, Image, SampleCounts};
use tracer::film::Film;

use crate::args::RenderArgs;
use crate::failure::{Verdict, usage};
use crate::interrupt;
use crate::output::{Outputs, Written};
use crate::progress::Progress;
use crate::report::estimated_rmse;
use crate::stdout::print_line;
use crate::threads::start_threads;

pub use adaptive_loop::{Budget, Finished, Sampling, trace_adaptively};
use checkpoint::Checkpoint;
pub use plan::Plan;
pub use record::{record_of, view_of};
use resume::Begun;
use tev::Preview;
use view::open;
pub use view::{View, open_scene};

/// Runs the command.
pub fn run(args: &RenderArgs, matches: &ArgMatches) -> Result<Verdict> {
    let start = Instant::now();
    let outputs = Outputs::prepare(&args.output, &args.stem())?;
    if !args.resume {
        refuse_to_lose(&partial_path(&outputs))?;
    }
    start_threads(&args.report)?;
    interrupt::listen();
    let progress = Progress::new(&args.report);
    let view = open(args, &progress)?;
    let plan = Plan::new(args, matches, view.render.as_ref())?;
    let camera = view.camera(plan.size)?;
    let shown = record::view_of(&view, &plan.settings);

    let found = if args.resume { Begun::find(&outputs, &plan, &shown, &progress)? } else { None };
    let (begun, film) = found.unzip();
    let new = || Film::new(plan.window, plan.size, &plan.settings.trace).starting_at(plan.budget.first);
    let film = film.unwrap_or_else(new);
    if let Some(begun) = begun.as_ref().filter(|begun| begun.is_finished(&film, &plan.budget, &outputs)) {
        let finished = Finished::nothing_new(film.into_stack());
        return say_that_nothing_is_missing(args, &outputs, &plan, (begun, &finished), &view, &progress);
    }
    let preview =
        args.tev.as_ref().map(|address| Preview::open(address, &args.stem(), plan.window.size)).transpose()?;
    let write = |stack: &FeatureStack| keep(stack, &outputs, &plan, &shown);
    let checkpoint = args.checkpoint.map(|every| Checkpoint::new(partial_path(&outputs), every, &write));
    let sampling = Sampling {
        scene: &view.scene,
        camera: &camera,
        settings: &plan.settings,
        progress: &progress,
        preview: preview.as_ref(),
        checkpoint: checkpoint.as_ref(),
    };
    let finished = trace_adaptively(&sampling, film, &plan.budget, plan.reconstruct)?;
    progress.finish();
    if finished.interrupted {
        write(&finished.stack)?;
        say_where_it_is_kept(args, &outputs, &finished.stack, &progress);
        return Ok(Verdict::Interrupted);
    }
    let picture = finished.picture();
    let (header, carried) = (header(&plan, &shown, &finished.stack.samples), Carried::default());
    let written = Written {
        picture: &picture,
        stack: &finished.stack,
        reconstruction: finished.reconstruction.as_ref(),
        header: &header,
        carried: &carried,
    };
    let writing = Instant::now();
    outputs.write(&written, &progress)?;
    if begun.is_some_and(|begun| begun.is_partial()) || checkpoint.is_some_and(|checkpoint| checkpoint.is_written()) {
        clear_away(&partial_path(&outputs), &progress);
    }
    let clock = report::Clock {
        load: view.load_seconds,
        build: view.build_seconds,
        write: writing.elapsed().as_secs_f64(),
        total: start.elapsed().as_secs_f64(),
    };
    say_what_was_done(&progress, &finished, &written, clock.total);
    if args.report.json {
        print_line(report::render(&outputs, &written, &plan, &finished, &clock, &progress, &view))?;
    }
    Ok(if finished.missed_target { Verdict::No } else { Verdict::Done })
}

fn header(plan: &Plan, shown: &Value, counts: &SampleCounts) -> StackHeader {
    let trace = &plan.settings.trace;
    StackHeader {
        first: plan.budget.first,
        sequences: trace.sequences,
        buckets: trace.buckets,
        per_bucket: None,
        settings: plan.settings.to_json(),
        record: Some(record::record_of(shown, trace.seed, counts)),
    }
}

/// Leaves a render alone that has all samples already.
fn say_that_nothing_is_missing(
    args: &RenderArgs,
    outputs: &Outputs,
    plan: &Plan,
    (begun, finished): (&Begun, &Finished),
    view: &View,
    progress: &Progress,
) -> Result<Verdict> {
    progress.say(&format!("nothing is missing in {}: it is left as it is", begun.file.display()));
    if args.report.json {
        let (picture, carried) = (begun.picture()?, Carried::default());
        let header = StackHeader::of(&finished.stack, Value::Null);
        let stack = &finished.stack;
        let written = Written { picture: &picture, stack, reconstruction: None, header: &header, carried: &carried };
        let (load, build) = (view.load_seconds, view.build_seconds);
        let clock = report::Clock { load, build, write: 0.0, total: load + build };
        print_line(report::render(outputs, &written, plan, finished, &clock, progress, view))?;
    }
    Ok(Verdict::Done)
}

/// Where an interrupted run leaves what it has: beside the first .exr output, else beside the first output.
fn partial_path(outputs: &Outputs) -> PathBuf {
    let files = outputs.files();
    let named = files.iter().find(|file| extension(file) == "exr").or(files.first());
    named.map_or_else(|| PathBuf::from("picture.partial.exr"), |file| file.with_extension("partial.exr"))
}

/// Refuses to begin where an interrupted run has left samples in `file`, which the next interruption would replace.
fn refuse_to_lose(file: &Path) -> Result<()> {
    if !file.exists() {
        return Ok(());
    }
    let file = file.display();
    Err(usage(format!(
        "{file} keeps the samples of a render that was interrupted: --resume goes on with it, or delete it"
    )))
}

/// Keeps the samples of a render that is not finished.
fn keep(stack: &FeatureStack, outputs: &Outputs, plan: &Plan, shown: &Value) -> Result<()> {
    let (picture, carried) = (stack.beauty(), Carried::default());
    let header = header(plan, shown, &stack.samples);
    let written = Written { picture: &picture, stack, reconstruction: None, header: &header, carried: &carried };
    outputs.write_partial(&partial_path(outputs), &written)
}

/// Removes what was kept of a render that is finished.
fn clear_away(file: &Path, progress: &Progress) {
    if let Err(error) = std::fs::remove_file(file) {
        progress.say(&format!("{} is of no more use, but cannot be removed: {error}", file.display()));
    }
}

fn say_where_it_is_kept(args: &RenderArgs, outputs: &Outputs, stack: &FeatureStack, progress: &Progress) {
    let path = partial_path(outputs);
    let (mean, ..) = stack.samples.mean_min_max();
    progress.say(&format!(
        "interrupted at {mean:.1} spp; kept in {} (tamis denoise {} -o {}; or go on with --resume)",
        path.display(),
        path.display(),
        first_name(outputs, &args.scene)
    ));
}

fn first_name(outputs: &Outputs, scene: &Path) -> String {
    outputs.files().first().unwrap_or(&scene.to_path_buf()).display().to_string()
}

fn say_what_was_done(progress: &Progress, finished: &Finished, written: &Written<'_>, seconds: f64) {
    let (mean, min, max) = written.stack.samples.mean_min_max();
    let error = estimated_rmse(written).map_or(String::new(), |e| format!(", estimated relative MSE {e:.2e}"));
    progress.say(&format!("{mean:.1} spp ({min} to {max}){error}"));
    if finished.not_finite > 0 {
        progress.say(&format!("{} samples were not finite and count as zero", finished.not_finite));
    }
    let stages: Vec<String> = progress.stage_seconds().iter().map(|(name, s)| format!("{name} {s:.1} s")).collect();
    progress.say(&format!("done in {seconds:.1} s ({})", stages.join(", ")));
}

impl Finished {
    /// What a loop leaves that had nothing to do.
    fn nothing_new(stack: stack::FeatureStack) -> Self {
        Self {
            stack,
            reconstruction: None,
            rounds: Vec::new(),
            samples: 0,
            rays: 0,
            not_finite: 0,
            interrupted: false,
            missed_target: false,
        }
    }

    /// The picture to show: reconstructed, or as it was sampled.
    pub fn picture(&self) -> Image {
        self.reconstruction.as_ref().map_or_else(|| self.stack.beauty(), |r| r.picture.clone())
    }
}
