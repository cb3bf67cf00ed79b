//! How many independent sequences a pixel's samples should be dealt from.
//!
//! One sequence is best spread and says least about its own noise; eight make every bucket independent and lose some of
//! the spreading. What counts is the error of the finished picture.

use anyhow::Result;

use super::reference::reference;
use super::scenes::judge;
use super::stage::Stage;
use crate::args::ExperimentArgs;
use crate::progress::Progress;
use crate::render::Budget;
use crate::table::{Table, maybe};

/// Numbers of sequences that are tried, each with eight buckets.
const SEQUENCES: [u32; 3] = [1, 2, 8];

/// Seeds whose errors are averaged: one picture says little about a difference of a few percent.
const SEEDS: u64 = 3;

/// Runs the experiment on every scene given.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let head = ["scene", "spp", "sequences", "noisy rMSE", "uniform rMSE", "adaptive rMSE", "adaptive trimmed"];
    let title =
        format!("Sequences per pixel, {}, mean of {SEEDS} seeds, against {} spp", args.size.0, args.reference_spp);
    let mut table = Table::new(title, &head);
    for file in &args.inputs {
        let stage = Stage::open(file, args, progress)?;
        let truth = reference(args, &stage, progress)?;
        for spp in &args.spp {
            for sequences in SEQUENCES {
                progress.say(&format!("{}: {sequences} sequences at {spp} spp", stage.name));
                let mut row = vec![stage.name.clone(), spp.to_string(), sequences.to_string()];
                row.extend(errors(args, &stage, [*spp, sequences], &truth, progress)?.map(|error| maybe(Some(error))));
                table.rows.push(row);
            }
        }
    }
    Ok(vec![table])
}

fn errors(
    args: &ExperimentArgs,
    stage: &Stage,
    [spp, sequences]: [u32; 2],
    truth: &stack::Image,
    progress: &Progress,
) -> Result<[f64; 4]> {
    let mut sums = [0.0; 4];
    for seed in 0..SEEDS {
        let mut settings = args.settings()?;
        settings.trace.seed = seed;
        settings.trace.sequences = sequences;
        let uniform = stage.render(&settings, &Budget::uniform(spp), true, progress)?;
        let adaptive = stage.render(&settings, &Budget { uniform: false, ..Budget::uniform(spp) }, true, progress)?;
        let noisy = judge(&uniform.stack.beauty(), truth)?;
        let (uniform, adaptive) = (judge(&uniform.picture(), truth)?, judge(&adaptive.picture(), truth)?);
        let found = [noisy.rmse, uniform.rmse, adaptive.rmse, adaptive.rmse_trimmed];
        for (sum, error) in sums.iter_mut().zip(found) {
            *sum += error.unwrap_or(f64::NAN) / SEEDS as f64;
        }
    }
    Ok(sums)
}
