//! Noisy pictures of varied scenes, and what they should have been.

use std::path::Path;

use anyhow::{Context, Result};
use reconstruct::rivals::lbf::training::Example;
use stack::{ComponentRole, FeatureStack, Image};

use super::variation::write_variation;
use crate::args::ExperimentArgs;
use crate::experiment::reference::reference_stack;
use crate::experiment::stage::{OWN_SCENES, Stage};
use crate::progress::Progress;

/// Variations of each scene.
const VARIATIONS: u64 = 8;

/// Renders every variation of our scenes at every number of samples.
///
/// # Errors
/// When a scene cannot be opened, varied or traced.
pub fn training_set(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Example>> {
    let seed = args.settings()?.trace.seed;
    let folder = args.output.join("scenes");
    std::fs::create_dir_all(&folder).with_context(|| format!("{}: cannot make the folder", folder.display()))?;
    let mut examples = Vec::new();
    for (scene, number) in OWN_SCENES.iter().flat_map(|scene| (0..VARIATIONS).map(move |number| (scene, number))) {
        let file = write_variation(Path::new(scene), &folder, seed, number)?;
        let stage = Stage::open(&file, args, progress)?;
        let reference = scattered(&reference_stack(args, &stage, progress)?);
        for spp in &args.spp {
            let mut settings = args.settings()?;
            settings.trace.seed = seed.wrapping_add(number + 1);
            let stack = stage.sample(&settings, *spp, progress)?;
            examples.push(Example::new(&stack, &reference, &settings.reconstruction.prefilter, progress)?);
        }
    }
    Ok(examples)
}

/// Light that is not seen directly; black when there is none.
pub fn scattered(stack: &FeatureStack) -> Image {
    let component = stack.component(ComponentRole::Scattered);
    component.map_or_else(|| Image::zeros(stack.size(), 3), |component| component.radiance.mean.clone())
}
