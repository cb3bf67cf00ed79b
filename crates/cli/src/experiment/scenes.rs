//! Noisy, uniform and adaptive pictures of whole scenes.

use std::time::Instant;

use anyhow::Result;
use reconstruct::metrics::{Comparison, Reference, compare};
use stack::Image;

use super::case::judged_by;
use super::geometric_mean::{geometric_mean, mean};
use super::reference::references;
use super::stage::Stage;
use crate::args::ExperimentArgs;
use crate::output::write_png;
use crate::progress::Progress;
use crate::render::{Budget, Finished};
use crate::table::{Table, maybe};

/// A picture's name, whether its samples are uniform, and whether it is rebuilt.
type Kind = (&'static str, bool, bool);

const KINDS: [Kind; 3] = [("noisy", true, false), ("uniform", true, true), ("adaptive", false, true)];

/// Runs the experiment on every scene given.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let mut head = vec!["scene", "spp", "picture", "seconds"];
    head.extend(["cross rMSE", "trimmed", "energy", "estimated rMSE", "most ÷ median spp"]);
    let sort = format!("{}, geometric mean of {} seeds, against two references of", args.size.0, args.seeds);
    let mut table = Table::new(format!("Scenes at {sort} {} spp", args.reference_spp), &head);
    let mut ratios = Table::new("Adaptive ÷ uniform", &["scene", "spp", "cross rMSE", "trimmed", "of each seed"]);
    for file in &args.inputs {
        let stage = Stage::open(file, args, progress)?;
        let truth = references(args, &stage, progress)?;
        write_png(&args.output.join(format!("{}-reference.png", stage.name)), &truth[0], exposure(&truth))?;
        for spp in &args.spp {
            let mut judged = Vec::new();
            for kind in KINDS {
                let found = judge_seeds(args, &stage, &truth, *spp, kind, progress)?;
                table.rows.push(row(&stage.name, *spp, kind.0, &found));
                judged.push(found);
            }
            ratios.rows.push(ratio(&stage.name, *spp, &judged[1], &judged[2]));
        }
    }
    Ok(vec![table, ratios])
}

/// One picture and its errors.
struct Judged {
    seconds: f64,
    comparison: Comparison,
    estimated: Option<f64>,
    /// Most samples of a pixel over the median.
    spread: f64,
}

fn judge_seeds(
    args: &ExperimentArgs,
    stage: &Stage,
    truth: &[Image; 2],
    spp: u32,
    (name, uniform, rebuild): Kind,
    progress: &Progress,
) -> Result<Vec<Judged>> {
    let mut found = Vec::new();
    for seed in 0..args.seeds {
        progress.say(&format!("{}: {name} at {spp} spp, seed {seed}", stage.name));
        let mut settings = args.settings()?;
        settings.trace.seed = seed;
        let start = Instant::now();
        let finished = stage.render(&settings, &Budget { uniform, ..Budget::uniform(spp) }, rebuild, progress)?;
        let seconds = start.elapsed().as_secs_f64();
        let picture = finished.picture();
        if seed == 0 {
            write_png(&args.output.join(format!("{}-{spp}-{name}.png", stage.name)), &picture, exposure(truth))?;
        }
        let comparison = judged_by(&picture, truth)?;
        let estimated = finished.rounds.last().and_then(|round| round.estimated_rmse);
        found.push(Judged { seconds, comparison, estimated, spread: spread(&finished) });
    }
    Ok(found)
}

fn spread(finished: &Finished) -> f64 {
    let mut counts = finished.stack.samples.total.clone();
    counts.sort_unstable();
    f64::from(counts[counts.len() - 1]) / f64::from(counts[counts.len() / 2])
}

/// Measures `picture` against one reference.
///
/// # Errors
/// When sizes differ.
pub fn judge(picture: &Image, truth: &Image) -> Result<Comparison> {
    Ok(compare(picture, &Reference::new(truth))?)
}

fn exposure(truth: &[Image; 2]) -> f32 {
    crate::exposure::choose(&truth[0])
}

fn row(scene: &str, spp: u32, name: &str, found: &[Judged]) -> Vec<String> {
    let of = |value: fn(&Judged) -> Option<f64>| found.iter().map(value);
    let values = [
        mean(of(|j| Some(j.seconds))),
        geometric_mean(of(|j| j.comparison.rmse_cross)),
        geometric_mean(of(|j| j.comparison.rmse_cross_trimmed)),
        mean(of(|j| j.comparison.energy_ratio)),
        geometric_mean(of(|j| j.estimated)),
        geometric_mean(of(|j| Some(j.spread))),
    ];
    [scene.to_string(), spp.to_string(), name.to_string()].into_iter().chain(values.map(maybe)).collect()
}

fn ratio(scene: &str, spp: u32, uniform: &[Judged], adaptive: &[Judged]) -> Vec<String> {
    let of = |error: fn(&Comparison) -> Option<f64>| {
        adaptive.iter().zip(uniform).map(move |(a, u)| Some(error(&a.comparison)? / error(&u.comparison)?))
    };
    let each: Vec<String> = of(|c| c.rmse_cross).map(maybe).collect();
    vec![
        scene.into(),
        spp.to_string(),
        maybe(geometric_mean(of(|c| c.rmse_cross))),
        maybe(geometric_mean(of(|c| c.rmse_cross_trimmed))),
        each.join(" "),
    ]
}
