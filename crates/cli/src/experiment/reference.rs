//! References, traced once and kept in the experiment's folder.

use std::path::Path;

use anyhow::Result;
use stack::file::{Carried, ResultLayer, StackHeader, read_stack, write_stack};
use stack::{FeatureStack, Image};
use tracer::film::Film;

use crate::args::ExperimentArgs;
use crate::experiment::scenes::Stage;
use crate::progress::Progress;
use crate::render::{Budget, Sampling, trace_adaptively};
use crate::settings::Settings;

/// Seeds of the first and of the second reference, far from those of pictures.
const SEEDS: [u64; 2] = [u64::MAX >> 32, u64::MAX >> 33];

/// The picture of `stage` at `args.reference_spp` uniform samples, with a seed of its own, as one sequence.
///
/// # Errors
/// When it can neither be read nor traced and written.
pub fn reference(args: &ExperimentArgs, stage: &Stage, progress: &Progress) -> Result<Image> {
    Ok(reference_stack(args, stage, progress)?.beauty())
}

/// [`reference()`] with its components and features.
///
/// # Errors
/// As [`reference()`].
pub fn reference_stack(args: &ExperimentArgs, stage: &Stage, progress: &Progress) -> Result<FeatureStack> {
    converged(args, stage, 0, progress)
}

/// The pictures of two independent references.
///
/// # Errors
/// As [`reference()`].
pub fn references(args: &ExperimentArgs, stage: &Stage, progress: &Progress) -> Result<[Image; 2]> {
    Ok(reference_stacks(args, stage, progress)?.map(|stack| stack.beauty()))
}

/// Two independent references, features included.
///
/// # Errors
/// As [`reference()`].
pub fn reference_stacks(args: &ExperimentArgs, stage: &Stage, progress: &Progress) -> Result<[FeatureStack; 2]> {
    Ok([converged(args, stage, 0, progress)?, converged(args, stage, 1, progress)?])
}

fn converged(args: &ExperimentArgs, stage: &Stage, which: usize, progress: &Progress) -> Result<FeatureStack> {
    let (size, spp) = (stage.camera.film, args.reference_spp);
    let file = args.output.join(format!("{}-{size}-{spp}spp-reference{}.exr", stage.name, which + 1));
    if !file.exists() {
        progress.say(&format!("{}: reference of {spp} spp", stage.name));
        trace(stage, &file, (SEEDS[which], spp), progress)?;
    }
    Ok(read_stack(&file)?.stack)
}

fn trace(stage: &Stage, file: &Path, (seed, spp): (u64, u32), progress: &Progress) -> Result<()> {
    let mut settings = Settings::default();
    settings.trace.seed = seed;
    (settings.trace.sequences, settings.trace.buckets) = (1, 1);
    let film = Film::new(stack::Window::whole(stage.camera.film), stage.camera.film, &settings.trace);
    let sampling = Sampling {
        scene: &stage.view.scene,
        camera: &stage.camera,
        settings: &settings,
        progress,
        preview: None,
        checkpoint: None,
    };
    let finished = trace_adaptively(&sampling, film, &Budget::uniform(spp), false)?;
    if finished.interrupted {
        return Err(stack::Cancelled.into());
    }
    let picture = finished.picture();
    let header = StackHeader {
        first: 0,
        sequences: 1,
        buckets: 1,
        per_bucket: None,
        settings: settings.to_json(),
        record: None,
    };
    let result = ResultLayer { name: "", channels: &["R", "G", "B"], planes: picture.channels() };
    Ok(write_stack(file, &finished.stack, true, &header, &[result], &Carried::default())?)
}
