//! `tamis render`: from a scene to a picture that knows its own error.

mod adaptive_loop;
mod plan;
pub mod report;
pub mod tev;
mod view;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use clap::ArgMatches;
use stack::Image;
use stack::file::{Carried, StackHeader, extension};
use tracer::film::Film;

use crate::args::{RenderArgs, ReportArgs};
use crate::failure::Verdict;
use crate::interrupt;
use crate::output::{Outputs, Written};
use crate::progress::Progress;
use crate::stdout::print_line;

pub use adaptive_loop::{Budget, Finished, Sampling, trace_adaptively};
pub use plan::Plan;
use tev::Preview;
use view::open;
pub use view::{View, open_scene};

/// Runs the command.
pub fn run(args: &RenderArgs, matches: &ArgMatches) -> Result<Verdict> {
    let start = Instant::now();
    let stem = args.scene.file_stem().map_or_else(|| "picture".into(), |stem| stem.to_string_lossy().into_owned());
    let outputs = Outputs::prepare(&args.output, &stem)?;
    start_threads(&args.report)?;
    interrupt::listen();
    let progress = Progress::new(&args.report);
    let view = open(args, &progress)?;
    let plan = Plan::new(args, matches, view.render.as_ref())?;
    let camera = view.camera(plan.size)?;

    let film = Film::new(plan.window, plan.size, &plan.settings.trace).starting_at(plan.budget.first);
    let preview = args.tev.as_ref().map(|address| Preview::open(address, &stem, plan.window.size)).transpose()?;
    let sampling = Sampling {
        scene: &view.scene,
        camera: &camera,
        settings: &plan.settings,
        progress: &progress,
        preview: preview.as_ref(),
    };
    let finished = trace_adaptively(&sampling, film, &plan.budget, plan.reconstruct)?;
    progress.finish();
    let picture = finished.picture();
    let (header, carried) = (header(&plan), Carried::default());
    let written = Written {
        picture: &picture,
        stack: &finished.stack,
        reconstruction: finished.reconstruction.as_ref(),
        header: &header,
        carried: &carried,
    };
    if finished.interrupted {
        return keep_partial(args, &outputs, &written, &progress);
    }
    let writing = Instant::now();
    outputs.write(&written, &progress)?;
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

fn header(plan: &Plan) -> StackHeader {
    let trace = &plan.settings.trace;
    StackHeader {
        first: plan.budget.first,
        sequences: trace.sequences,
        buckets: trace.buckets,
        per_bucket: None,
        settings: plan.settings.to_json(),
    }
}

/// Where an interrupted run leaves what it has: beside the first .exr output, else beside the first output.
fn partial_path(outputs: &Outputs) -> PathBuf {
    let files = outputs.files();
    let named = files.iter().find(|file| extension(file) == "exr").or(files.first());
    named.map_or_else(|| PathBuf::from("picture.partial.exr"), |file| file.with_extension("partial.exr"))
}

fn keep_partial(args: &RenderArgs, outputs: &Outputs, written: &Written<'_>, progress: &Progress) -> Result<Verdict> {
    let path = partial_path(outputs);
    let noisy = written.stack.beauty();
    let kept = Written { picture: &noisy, reconstruction: None, ..*written };
    outputs.write_partial(&path, &kept)?;
    let (mean, ..) = written.stack.samples.mean_min_max();
    progress.say(&format!(
        "interrupted at {mean:.1} spp; kept in {} (tamis denoise {} -o {})",
        path.display(),
        path.display(),
        first_name(outputs, &args.scene)
    ));
    Ok(Verdict::Interrupted)
}

fn first_name(outputs: &Outputs, scene: &Path) -> String {
    outputs.files().first().unwrap_or(&scene.to_path_buf()).display().to_string()
}

fn say_what_was_done(progress: &Progress, finished: &Finished, written: &Written<'_>, seconds: f64) {
    let (mean, min, max) = written.stack.samples.mean_min_max();
    let error = report::estimated_rmse(written).map_or(String::new(), |e| format!(", estimated relative MSE {e:.2e}"));
    progress.say(&format!("{mean:.1} spp ({min} to {max}){error}"));
    if finished.not_finite > 0 {
        progress.say(&format!("{} samples were not finite and count as zero", finished.not_finite));
    }
    let stages: Vec<String> = progress.stage_seconds().iter().map(|(name, s)| format!("{name} {s:.1} s")).collect();
    progress.say(&format!("done in {seconds:.1} s ({})", stages.join(", ")));
}

impl Finished {
    /// The picture to show: reconstructed, or as it was sampled.
    pub fn picture(&self) -> Image {
        self.reconstruction.as_ref().map_or_else(|| self.stack.beauty(), |r| r.picture.clone())
    }
}
