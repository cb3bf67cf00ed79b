//! Reference pictures, traced once and kept in the experiment's folder.

use std::path::Path;

use anyhow::Result;
use stack::Image;
use stack::file::{read_picture, write_picture};
use tracer::film::Film;

use crate::args::ExperimentArgs;
use crate::experiment::scenes::Stage;
use crate::progress::Progress;
use crate::render::{Budget, Sampling, trace_adaptively};
use crate::settings::Settings;

/// Seed of the first reference; the second one's is the number before.
const SEED: u64 = u64::MAX >> 32;

/// The picture of `stage` at `args.reference_spp` uniform samples, with a seed of its own, as one sequence.
///
/// # Errors
/// When it can neither be read nor traced and written.
pub fn reference(args: &ExperimentArgs, stage: &Stage, progress: &Progress) -> Result<Image> {
    kept(args, stage, SEED, "", progress)
}

/// Two of them, with independent noise.
///
/// # Errors
/// As [`reference`].
pub fn references(args: &ExperimentArgs, stage: &Stage, progress: &Progress) -> Result<[Image; 2]> {
    Ok([reference(args, stage, progress)?, kept(args, stage, SEED - 1, "-second", progress)?])
}

fn kept(args: &ExperimentArgs, stage: &Stage, seed: u64, suffix: &str, progress: &Progress) -> Result<Image> {
    let size = stage.camera.film;
    let file = args.output.join(format!("{}-{size}-{}spp{suffix}.exr", stage.name, args.reference_spp));
    if file.exists() {
        return Ok(read_picture(&file)?);
    }
    trace_reference(args, stage, seed, &file, progress)
}

fn trace_reference(args: &ExperimentArgs, stage: &Stage, seed: u64, file: &Path, progress: &Progress) -> Result<Image> {
    progress.say(&format!("{}: reference of {} spp", stage.name, args.reference_spp));
    let mut settings = Settings::default();
    settings.trace.seed = seed;
    (settings.trace.sequences, settings.trace.buckets) = (1, 1);
    let film = Film::new(stack::Window::whole(stage.camera.film), stage.camera.film, &settings.trace);
    let sampling = Sampling { scene: &stage.view.scene, camera: &stage.camera, settings: &settings, progress };
    let finished = trace_adaptively(&sampling, film, &Budget::uniform(args.reference_spp), false)?;
    if finished.interrupted {
        return Err(stack::Cancelled.into());
    }
    let picture = finished.picture();
    write_picture(file, &picture)?;
    Ok(picture)
}
