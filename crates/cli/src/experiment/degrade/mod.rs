//! How errors grow as a stack knows less.

mod level;

use anyhow::Result;
use reconstruct::metrics::Comparison;
use reconstruct::reconstruct;
use stack::file::write_picture;
use stack::{FeatureStack, Image};

use self::level::Level;
use super::calibration::{Judged, calibrate};
use super::case::{Case, Entry, settings};
use crate::args::ExperimentArgs;
use crate::progress::Progress;
use crate::settings::{Preset, Settings};
use crate::table::{Table, maybe, short};

/// Methods that are set beside what was asked for.
const RIVALS: &[Entry] = &[
    ("nfor", Preset::Paper, &[("method", "nfor")]),
    ("wlr", Preset::Paper, &[("method", "wlr")]),
    ("apr", Preset::Paper, &[("method", "apr")]),
    ("paper", Preset::Paper, &[]),
];

/// Runs the experiment on every folder given.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let head = ["stack", "what it has", "method", "cross rMSE", "trimmed", "energy", "estimated over true error"];
    let mut table = Table::new("What is left of quality as a stack knows less", &head);
    for input in &args.inputs {
        let case = Case::open_poor(input)?;
        table.rows.push(row([&case.name, "", "noisy"], &case.judge(&case.stack.beauty())?, None));
        for level in Level::ALL {
            if let Some(stack) = level.of(&case.stack) {
                table.rows.extend(of_level(&case, level, &stack, args, progress)?);
            }
        }
    }
    Ok(vec![table])
}

/// All methods on one stack; writes their pictures.
fn of_level(
    case: &Case,
    level: Level,
    stack: &FeatureStack,
    args: &ExperimentArgs,
    progress: &Progress,
) -> Result<Vec<Vec<String>>> {
    let mut methods = vec![("best", args.settings()?)];
    for (name, preset, flags) in RIVALS {
        methods.push((name, settings(*preset, flags)?));
    }
    let mut rows = Vec::new();
    for (name, settings) in methods {
        progress.say(&format!("{}, {}: {name}", case.name, level.name()));
        let (picture, ratio) = rebuilt(case, stack, &settings, progress)?;
        let file = format!("{}-{}-{name}.exr", case.name, level.name().replace([',', ' '], "_"));
        write_picture(&args.output.join(file), &picture)?;
        rows.push(row([&case.name, level.name(), name], &case.judge(&picture)?, Some(ratio)));
    }
    let oidn = if level == Level::Colour { "oidn-colour" } else { "oidn" };
    if let Some(picture) = case.other(oidn) {
        rows.push(row([&case.name, level.name(), "oidn"], &case.judge(picture)?, None));
    }
    Ok(rows)
}

/// The picture, and its estimated over its true squared error.
fn rebuilt(case: &Case, stack: &FeatureStack, settings: &Settings, progress: &Progress) -> Result<(Image, f64)> {
    let found = reconstruct(stack, &settings.reconstruction, progress)?;
    let references = &case.references;
    let judged = Judged { picture: &found.picture, mse: &found.mse, raw_variance: &found.mse, references };
    let [estimate, truth] = calibrate(&judged).trimmed;
    Ok((found.picture, estimate / truth))
}

fn row(names: [&str; 3], comparison: &Comparison, ratio: Option<f64>) -> Vec<String> {
    let c = comparison;
    let measures = [c.rmse_cross, c.rmse_cross_trimmed, c.energy_ratio].map(maybe);
    names.map(String::from).into_iter().chain(measures).chain([ratio.map_or_else(|| "-".into(), short)]).collect()
}
