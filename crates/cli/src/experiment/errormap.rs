//! Whether the error map is honest: estimated against true squared error, and how well it ranks pixels.

use std::path::Path;

use anyhow::Result;
use reconstruct::reconstruct;
use stack::{FeatureStack, Image};

use super::calibration::{Calibration, Judged, calibrate};
use super::case::Case;
use super::geometric_mean::geometric_mean;
use super::reference::references;
use super::stage::Stage;
use crate::args::ExperimentArgs;
use crate::progress::Progress;
use crate::table::{Table, maybe, short};

/// Runs the experiment on every scene and every folder of buckets.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let mut found = Vec::new();
    for input in &args.inputs {
        if input.is_dir() {
            let case = Case::open(input)?;
            found.push((case.name.clone(), judge(&case.stack, &case.references, args, progress)?));
        } else {
            found.extend(of_scene(input, args, progress)?);
        }
    }
    let truth = format!("{} at {}, against two references of {} spp", "Error map", args.size.0, args.reference_spp);
    Ok(vec![calibration_table(&truth, &found), ranking_table(&found)])
}

/// One scene at every number of samples.
fn of_scene(file: &Path, args: &ExperimentArgs, progress: &Progress) -> Result<Vec<(String, Calibration)>> {
    let stage = Stage::open(file, args, progress)?;
    let references = references(args, &stage, progress)?;
    let mut found = Vec::new();
    for spp in &args.spp {
        for seed in 0..args.seeds {
            progress.say(&format!("{}: {spp} spp, seed {seed}", stage.name));
            let mut settings = args.settings()?;
            settings.trace.seed = seed;
            let stack = stage.sample(&settings, *spp, progress)?;
            let calibration = judge(&stack, &references, args, progress)?;
            found.push((format!("{} {spp} spp", stage.name), calibration));
        }
    }
    Ok(found)
}

fn judge(
    stack: &FeatureStack,
    references: &[Image; 2],
    args: &ExperimentArgs,
    progress: &Progress,
) -> Result<Calibration> {
    let rebuilt = reconstruct(stack, &args.settings()?.reconstruction, progress)?;
    let raw = raw_variance(stack);
    Ok(calibrate(&Judged { picture: &rebuilt.picture, mse: &rebuilt.mse, raw_variance: &raw, references }))
}

/// Variance of the noisy picture, mean over RGB; 0 where it is unknown.
fn raw_variance(stack: &FeatureStack) -> Vec<f32> {
    let mut sum = vec![0.0; stack.size().pixels()];
    for component in &stack.components {
        let Some(variance) = component.radiance.variance_of_mean(&stack.samples) else { continue };
        for (pixel, sum) in sum.iter_mut().enumerate() {
            let v = variance.mean_at(pixel);
            *sum += if v.is_finite() { v } else { 0.0 };
        }
    }
    sum
}

fn calibration_table(title: &str, found: &[(String, Calibration)]) -> Table {
    let mut table =
        Table::new(format!("{title}: mean estimate ÷ mean truth, overall and by decile of brightness"), &[]);
    table.head = ["picture", "overall", "trimmed"].map(String::from).to_vec();
    table.head.extend((1..=10).map(|decile| format!("{decile}")));
    let mut row = |name: &str, calibration: &Calibration| {
        let [estimated, truth] = calibration.trimmed;
        let cells = [name.to_string(), short(calibration.ratio()), short(estimated / truth)];
        table.rows.push(cells.into_iter().chain(calibration.ratios().map(maybe)).collect());
    };
    found.iter().for_each(|(name, calibration)| row(name, calibration));
    row("all", &Calibration::pooled(found.iter().map(|(_, calibration)| calibration)));
    table.rows.push(geometric_means(found));
    table
}

/// Ratios of single pictures, so that no picture drowns the others.
fn geometric_means(found: &[(String, Calibration)]) -> Vec<String> {
    let of = |ratio: &dyn Fn(&Calibration) -> Option<f64>| {
        let known = found.iter().filter_map(|(_, calibration)| ratio(calibration).filter(|ratio| *ratio > 0.0));
        maybe(geometric_mean(known.map(Some)))
    };
    let mut row = vec!["geometric mean".into(), of(&|c| Some(c.ratio())), of(&|c| Some(c.trimmed[0] / c.trimmed[1]))];
    row.extend((0..10).map(|part| of(&|c: &Calibration| c.ratios()[part])));
    row
}

fn ranking_table(found: &[(String, Calibration)]) -> Table {
    let head = ["picture", "mse", "raw variance", "mse ÷ raw variance", "relative mse ÷ raw variance"];
    let mut table = Table::new("Area between the sparsification curve and the oracle's, of the mean error", &head);
    let mut row = |name: &str, calibration: &Calibration| {
        let ([mse, raw], [relative, relative_raw]) = (calibration.areas, calibration.relative_areas);
        table.rows.push(vec![name.into(), short(mse), short(raw), short(mse / raw), short(relative / relative_raw)]);
    };
    found.iter().for_each(|(name, calibration)| row(name, calibration));
    row("all", &Calibration::pooled(found.iter().map(|(_, calibration)| calibration)));
    table
}
