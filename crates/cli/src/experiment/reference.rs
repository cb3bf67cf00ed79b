//! References, traced once and kept in the experiment's folder.

use std::path::Path;

use anyhow::Result;
use serde_json::Value;
use stack::file::{Carried, ResultLayer, StackHeader, read_render, read_stack, write_stack};
use stack::merge::first_difference;
use stack::{FeatureStack, Image};

use crate::args::ExperimentArgs;
use crate::experiment::stage::Stage;
use crate::progress::Progress;
use crate::render::{Budget, record_of, view_of};
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
    let settings = settings(SEEDS[which]);
    let shown = view_of(&stage.view, &settings);
    if let Some(kept) = kept(&file, &shown) {
        return Ok(kept);
    }
    progress.say(&format!("{}: reference of {spp} spp", stage.name));
    trace(stage, &file, (&settings, spp), shown, progress)?;
    Ok(read_stack(&file)?.stack)
}

/// What an earlier run has left in `file`, if it shows the same: a scene of that name may have been edited since, or be another.
fn kept(file: &Path, shown: &Value) -> Option<FeatureStack> {
    let (read, record) = read_render(file).ok()?;
    first_difference(shown, &record.view).is_none().then_some(read.stack)
}

/// The default's, with one sequence.
fn settings(seed: u64) -> Settings {
    let mut settings = Settings::default();
    settings.trace.seed = seed;
    (settings.trace.sequences, settings.trace.buckets) = (1, 1);
    settings
}

fn trace(
    stage: &Stage,
    file: &Path,
    (settings, spp): (&Settings, u32),
    shown: Value,
    progress: &Progress,
) -> Result<()> {
    let finished = stage.render(settings, &Budget::uniform(spp), false, progress)?;
    let (picture, counts) = (finished.picture(), &finished.stack.samples);
    let header = StackHeader {
        first: 0,
        sequences: 1,
        buckets: 1,
        per_bucket: None,
        settings: settings.to_json(),
        record: Some(record_of(&shown, settings.trace.seed, counts)),
        samples_unknown: false,
    };
    let result = ResultLayer { name: "", channels: &["R", "G", "B"], planes: picture.channels() };
    Ok(write_stack(file, &finished.stack, true, &header, &[result], &Carried::default())?)
}
