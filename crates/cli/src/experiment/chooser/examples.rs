//! Noisy pictures of varied scenes and of rooms with two references each.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use reconstruct::best::training::Example;

use super::room::write_room;
use crate::args::ExperimentArgs;
use crate::experiment::learning::variation::write_variation;
use crate::experiment::reference::reference_stacks;
use crate::experiment::stage::{OWN_SCENES, Stage};
use crate::progress::Progress;

/// Variations of each of our scenes.
const VARIATIONS: u64 = 3;
/// Rooms.
const ROOMS: u64 = 80;

/// Renders every variation of our scenes and every room at every number of samples.
///
/// # Errors
/// When a scene cannot be opened, varied, traced or rebuilt.
pub fn examples(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Example>> {
    let seed = args.settings()?.trace.seed;
    let mut examples = Vec::new();
    for (number, file) in scenes(args, seed)?.iter().enumerate() {
        examples.extend(of_scene(file, seed.wrapping_add(number as u64 + 1), args, progress)?);
    }
    Ok(examples)
}

/// Writes the scenes.
fn scenes(args: &ExperimentArgs, seed: u64) -> Result<Vec<PathBuf>> {
    let folder = args.output.join("scenes");
    std::fs::create_dir_all(&folder).with_context(|| format!("{}: cannot make the folder", folder.display()))?;
    let varied = OWN_SCENES.iter().flat_map(|scene| (0..VARIATIONS).map(move |number| (scene, number)));
    let varied = varied.map(|(scene, number)| write_variation(Path::new(scene), &folder, seed, number));
    varied.chain((0..ROOMS).map(|number| write_room(&folder, seed, number))).collect()
}

fn of_scene(file: &Path, seed: u64, args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Example>> {
    let stage = Stage::open(file, args, progress)?;
    let references = reference_stacks(args, &stage, progress)?;
    let mut settings = args.settings()?;
    settings.trace.seed = seed;
    let mut examples = Vec::new();
    for spp in &args.spp {
        progress.say(&format!("{}: {spp} spp", stage.name));
        let stack = stage.sample(&settings, *spp, progress)?;
        examples.extend(Example::all_of(&stack, &references, &settings.reconstruction.best, seed, progress)?);
    }
    Ok(examples)
}
