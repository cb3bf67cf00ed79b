//! `--resume`: goes on from the samples that an earlier run has written.

use std::path::PathBuf;

use anyhow::Result;
use serde_json::Value;
use stack::file::{extension, read_picture, read_render};
use stack::merge::{Held, Record, first_difference};
use stack::{Dealing, FeatureStack, Image, SampleCounts};
use tracer::film::Film;

use super::partial::partial_path;
use super::{Budget, Plan};
use crate::failure::usage;
use crate::output::Outputs;
use crate::progress::Progress;

/// Where the samples were that a render goes on from.
pub struct Begun {
    /// The file.
    pub file: PathBuf,
    /// Whether an interrupted run left it.
    is_partial: bool,
}

impl Begun {
    /// Looks for what an earlier run left, its output or what was kept when it was interrupted, whichever holds more;
    /// and its samples.
    ///
    /// # Errors
    /// When that cannot be read, or is no part of the same render.
    pub fn find(outputs: &Outputs, plan: &Plan, view: &Value, progress: &Progress) -> Result<Option<(Self, Film)>> {
        let partial = partial_path(outputs);
        let output = outputs.files().iter().find(|file| extension(file) == "exr").cloned();
        let mut found: Option<(PathBuf, FeatureStack, Record)> = None;
        for file in output.into_iter().chain([partial.clone()]).filter(|file| file.exists()) {
            let (read, record) = read_render(&file)?;
            let counts = &read.stack.samples;
            if found.as_ref().is_none_or(|(_, other, _)| samples(counts) > samples(&other.samples)) {
                found = Some((file, read.stack, record));
            }
        }
        let Some((file, stack, record)) = found else {
            progress.say("nothing to resume from: rendering from the start");
            return Ok(None);
        };
        if let Some([field, expected, found]) = misfit(plan, view, &stack, &record) {
            let otherwise = if file == partial { "delete it" } else { "leave --resume out" };
            return Err(usage(format!(
                "--resume: {}: {field}: expected {expected}, found {found}; give the flags it was rendered with, or {otherwise}",
                file.display()
            )));
        }
        let (mean, ..) = stack.samples.mean_min_max();
        progress.say(&format!("resumed at {mean:.1} spp from {}", file.display()));
        Ok(Some((Self { is_partial: file == partial, file }, Film::from_stack(stack)?)))
    }

    /// Whether all `outputs` are there already, with all samples that are asked for. Whether they reach a target, only
    /// a reconstruction can tell.
    pub fn is_finished(&self, film: &Film, budget: &Budget, outputs: &Outputs) -> bool {
        let are_there = outputs.files().iter().all(|file| file.exists());
        !self.is_partial && are_there && budget.target_error.is_none() && budget.is_spent_by(film.counts())
    }

    /// The picture as it stands in the file.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn picture(&self) -> Result<Image> {
        Ok(read_picture(&self.file)?)
    }

    /// Whether an interrupted run left it.
    pub const fn is_partial(&self) -> bool {
        self.is_partial
    }
}

fn samples(counts: &SampleCounts) -> u64 {
    counts.total.iter().map(|n| u64::from(*n)).sum()
}

/// In what a stack is not what `plan` would begin: the field, what is expected and what was found.
fn misfit(plan: &Plan, view: &Value, stack: &FeatureStack, record: &Record) -> Option<[String; 3]> {
    let differ = |field: &str, expected: String, found: String| {
        (expected != found).then(|| [field.to_string(), expected, found])
    };
    let crop = |window: &stack::Window| format!("{},{} {}", window.x, window.y, window.size);
    let range = |held: &Held| format!("{}..{} of seed {}", held.first, held.end, held.seed);
    let seed = plan.settings.trace.seed;
    let (.., most) = stack.samples.mean_min_max();
    // Of the same samples, with as many as there are.
    let own = Held { first: plan.budget.first, end: plan.budget.first.saturating_add(most), seed };
    let dealing = match stack.samples.dealing {
        Dealing::Numbered { .. } => "without a gap",
        Dealing::PerBucket(_) | Dealing::PerPixel(_) => "with gaps",
    };
    let view = || first_difference(view, &record.view).map(|d| [d.field, d.expected, d.found]);
    let seeds = || record.held.iter().map(|held| held.seed.to_string()).collect::<Vec<_>>().join(", ");
    differ("size", plan.size.to_string(), stack.film.to_string())
        .or_else(|| differ("crop", crop(&plan.window), crop(&stack.window)))
        .or_else(view)
        .or_else(|| differ("seed", seed.to_string(), seeds()).filter(|_| record.held.iter().any(|h| h.seed != seed)))
        .or_else(|| {
            let held = record.held.iter().map(range).collect::<Vec<_>>().join(", ");
            differ("samples", range(&own), held)
        })
        .or_else(|| differ("samples", "without a gap".into(), dealing.into()))
}
