//! What figures are made of: noisy samples with two references.

use std::path::{Path, PathBuf};

use anyhow::Result;
use stack::FeatureStack;

use crate::args::ExperimentArgs;
use crate::experiment::case::Case;
use crate::experiment::reference::reference_stacks;
use crate::experiment::stage::{OWN_SCENES, Stage};
use crate::exposure;
use crate::output::write_png;
use crate::progress::Progress;
use crate::settings::Settings;

/// A stack with its references, and the scene it was rendered from when it was rendered here.
pub struct Subject {
    /// Samples and references.
    pub case: Case,
    /// The scene.
    pub stage: Option<Stage>,
    /// A stack of so many samples that its features can be called right.
    pub converged: Option<FeatureStack>,
    /// Exposure of all its pictures, in stops.
    pub stops: f32,
}

impl Subject {
    /// Opens every input, or the project's own scenes when there is none; writes the pictures of the references.
    ///
    /// # Errors
    /// When one cannot be opened, or its references can neither be read nor traced.
    pub fn open_all(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Self>> {
        let own = OWN_SCENES.map(PathBuf::from);
        let inputs = if args.inputs.is_empty() { &own[..] } else { &args.inputs };
        inputs.iter().map(|input| Self::open(input, args, progress)).collect()
    }

    fn open(input: &Path, args: &ExperimentArgs, progress: &Progress) -> Result<Self> {
        let subject = if input.is_dir() { Self::of(Case::open(input)?) } else { Self::render(input, args, progress)? };
        let file = args.output.join(format!("{}-reference.png", subject.case.name));
        write_png(&file, &subject.case.references[0], subject.stops)?;
        Ok(subject)
    }

    fn of(case: Case) -> Self {
        let stops = exposure::choose(&case.references[0]);
        Self { case, stage: None, converged: None, stops }
    }

    /// Renders a scene uniformly, with the largest of `args.spp`.
    fn render(file: &Path, args: &ExperimentArgs, progress: &Progress) -> Result<Self> {
        let stage = Stage::open(file, args, progress)?;
        let converged = reference_stacks(args, &stage, progress)?;
        let spp = args.spp.iter().copied().max().unwrap_or(1);
        let stack = stage.sample(&Settings::default(), spp, progress)?;
        let references = [converged[0].beauty(), converged[1].beauty()];
        let case = Case { name: stage.name.clone(), stack, references, others: Vec::new() };
        let [converged, _] = converged;
        Ok(Self { stage: Some(stage), converged: Some(converged), ..Self::of(case) })
    }
}
