//! `tamis render`: from a scene to a picture that knows its own error.

mod adaptive_loop;
mod budget;
mod checkpoint;
mod finished;
mod partial;
mod plan;
mod record;
mod report;
mod resume;
mod tev;
mod time_left;
mod view;

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use clap::ArgMatches;
use serde_json::Value;
use stack::file::{Carried, StackHeader};
use stack::{FeatureStack, SampleCounts};
use tracer::camera::Camera;
use tracer::film::Film;
use tracer::integrator::TraceReport;

use crate::args::RenderArgs;
use crate::exposure::Lit;
use crate::failure::Verdict;
use crate::guide::Guide;
use crate::interrupt;
use crate::output::{Outputs, Written};
use crate::progress::Progress;
use crate::report::{done_in, estimated_rmse};
use crate::stdout::print_line;
use crate::threads::start_threads;

pub use adaptive_loop::{Sampling, trace_adaptively};
pub use budget::Budget;
use checkpoint::Checkpoint;
pub use finished::Finished;
use partial::{clear_away, partial_path, refuse_to_lose};
pub use plan::Plan;
pub use record::{record_of, view_of};
use resume::Begun;
use tev::Preview;
use view::open;
pub use view::{View, load_named, open_scene};

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
    let shown = view_of(&view, &plan.settings);
    Render { args, start, outputs, progress, view, plan, camera, shown }.run()
}

/// A render, checked and ready to begin.
struct Render<'a> {
    args: &'a RenderArgs,
    start: Instant,
    outputs: Outputs,
    progress: Progress,
    view: View,
    plan: Plan,
    camera: Camera,
    /// What its samples show.
    shown: Value,
}

impl Render<'_> {
    fn run(&self) -> Result<Verdict> {
        let Self { args, outputs, plan, progress, .. } = self;
        let found = if args.resume { Begun::find(outputs, plan, &self.shown, progress)? } else { None };
        let (begun, film) = found.unzip();
        let new = || Film::new(plan.window, plan.size, &plan.settings.trace).starting_at(plan.budget.first);
        let film = film.unwrap_or_else(new);
        if let Some(begun) = begun.as_ref().filter(|begun| begun.is_finished(&film, &plan.budget, outputs)) {
            return self
                .say_that_nothing_is_missing(begun, &Finished::unrebuilt(film.into_stack(), &TraceReport::default()));
        }
        let keep = |stack: &FeatureStack| self.keep(stack);
        let checkpoint = args.checkpoint.map(|every| Checkpoint::new(partial_path(outputs), every, &keep));
        let finished = self.sample(film, checkpoint.as_ref())?;
        if finished.interrupted {
            self.keep(&finished.stack)?;
            self.say_where_it_is_kept(&finished.stack);
            return Ok(Verdict::Interrupted);
        }
        let is_kept = begun.is_some_and(|begun| begun.is_partial()) || checkpoint.is_some_and(|kept| kept.is_written());
        self.write(&finished, is_kept)?;
        Ok(if finished.missed_target { Verdict::No } else { Verdict::Done })
    }

    /// Traces and reconstructs.
    fn sample(&self, film: Film, checkpoint: Option<&Checkpoint<'_>>) -> Result<Finished> {
        let Self { args, plan, progress, .. } = self;
        let preview = |address| Preview::open(address, &args.stem(), plan.window.size);
        let preview = args.tev.as_ref().map(preview).transpose()?;
        let sampling = Sampling {
            scene: &self.view.scene,
            camera: &self.camera,
            settings: &plan.settings,
            progress,
            preview: preview.as_ref(),
            checkpoint,
        };
        // One that does not fit is found before the work.
        let guide = args.guide.as_deref().map(|file| Guide::read((file, file), plan.window.size)).transpose()?;
        let mut finished = trace_adaptively(&sampling, film, &plan.budget, plan.reconstruct)?;
        if let (Some(guide), Some(rebuilt)) = (guide, &mut finished.reconstruction) {
            match guide.mix(&finished.stack, rebuilt, &plan.settings.reconstruction, progress) {
                Ok(followed) => finished.guide = Some(followed),
                // The samples are kept, as when anything else is interrupted.
                Err(_) if interrupt::requested() => finished.interrupted = true,
                Err(error) => return Err(error),
            }
        }
        progress.finish();
        Ok(finished)
    }

    /// Writes all outputs, clears away what `is_kept` of the unfinished render, and says what was done.
    fn write(&self, finished: &Finished, is_kept: bool) -> Result<()> {
        let Self { outputs, plan, progress, view, .. } = self;
        let picture = finished.picture();
        let (header, carried) = (self.header(&finished.stack.samples), Carried::default());
        let written = Written {
            picture: &picture,
            stack: &finished.stack,
            reconstruction: finished.reconstruction.as_ref(),
            header: &header,
            carried: &carried,
        };
        let writing = Instant::now();
        outputs.write(&written, &Lit::of(&finished.stack.beauty()), progress)?;
        if is_kept {
            clear_away(&partial_path(outputs), progress);
        }
        let clock = report::Clock {
            load: view.load_seconds,
            build: view.build_seconds,
            write: writing.elapsed().as_secs_f64(),
            total: self.start.elapsed().as_secs_f64(),
        };
        say_what_was_done(progress, finished, &written, clock.total);
        self.say_that_the_target_was_missed(finished, &written);
        if self.args.report.json {
            let written = &written;
            print_line(report::Rendered { outputs, written, plan, finished, clock, progress, view }.json())?;
        }
        Ok(())
    }

    /// Why the answer is no.
    fn say_that_the_target_was_missed(&self, finished: &Finished, written: &Written<'_>) {
        let Some(target) = self.plan.budget.target_error.filter(|_| finished.missed_target) else { return };
        let error = estimated_rmse(written).map_or_else(|| "unknown".into(), |error| format!("{error:.2e}"));
        self.progress.say(&format!(
            "--target-error {target:e} is not reached: the estimate is {error}; give it more samples or time, and go on with --resume"
        ));
    }

    /// Leaves a render alone that has all samples already.
    fn say_that_nothing_is_missing(&self, begun: &Begun, finished: &Finished) -> Result<Verdict> {
        let Self { outputs, plan, progress, view, .. } = self;
        progress.say(&format!("nothing is missing in {}: it is left as it is", begun.file.display()));
        if self.args.report.json {
            let (picture, carried) = (begun.picture()?, Carried::default());
            let stack = &finished.stack;
            let header = StackHeader::of(stack, Value::Null);
            let written =
                Written { picture: &picture, stack, reconstruction: None, header: &header, carried: &carried };
            let (load, build) = (view.load_seconds, view.build_seconds);
            let clock = report::Clock { load, build, write: 0.0, total: load + build };
            let written = &written;
            print_line(report::Rendered { outputs, written, plan, finished, clock, progress, view }.json())?;
        }
        Ok(Verdict::Done)
    }

    /// What the file says about samples with these `counts`.
    fn header(&self, counts: &SampleCounts) -> StackHeader {
        let trace = &self.plan.settings.trace;
        StackHeader {
            first: self.plan.budget.first,
            sequences: trace.sequences,
            buckets: trace.buckets,
            per_bucket: None,
            settings: self.plan.settings.to_json(),
            record: Some(record_of(&self.shown, trace.seed, counts)),
            samples_unknown: false,
        }
    }

    /// Keeps the samples of a render that is not finished.
    fn keep(&self, stack: &FeatureStack) -> Result<()> {
        let (picture, carried) = (stack.beauty(), Carried::default());
        let header = self.header(&stack.samples);
        let written = Written { picture: &picture, stack, reconstruction: None, header: &header, carried: &carried };
        self.outputs.write_partial(&partial_path(&self.outputs), &written)
    }

    fn say_where_it_is_kept(&self, stack: &FeatureStack) {
        let path = partial_path(&self.outputs);
        let path = path.display();
        let (mean, ..) = stack.samples.mean_min_max();
        let output = first_name(&self.outputs, &self.args.scene);
        self.progress.say(&format!(
            "interrupted at {mean:.1} spp; kept in {path} (tamis denoise {path} -o {output}; or go on with --resume)"
        ));
    }
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
    progress.say(&done_in(seconds, progress));
}
