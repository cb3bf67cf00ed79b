//! Trains the network that helps to mix candidates on variations of our scenes and on rooms of chance, and judges it on pictures it has not seen,
//! beside the rule without it.

mod examples;
mod room;

use anyhow::{Context, Result};
use reconstruct::best::Chooser;
use reconstruct::best::training::{TrainingSettings, train};
use reconstruct::metrics::Comparison;
use reconstruct::reconstruct_with_chooser;

use super::case::Case;
use super::geometric_mean::geometric_mean;
use super::learning::held_out::held_out;
use super::table::{Table, maybe};
use crate::args::ExperimentArgs;
use crate::progress::Progress;
use crate::settings::Settings;

/// How the network is trained, but for the seed.
const TRAINING: TrainingSettings = TrainingSettings { steps: 300, blocks: 32, rate: 0.01, decay: 1e-4, seed: 0 };

/// Runs the experiment; writes the weights to `weights.txt` in its folder.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let settings = args.settings()?;
    let examples = examples::examples(args, progress)?;
    let chooser = train(&examples, &TrainingSettings { seed: settings.trace.seed, ..TRAINING }, progress)?;
    let path = args.output.join("weights.txt");
    std::fs::write(&path, chooser.to_text()).with_context(|| format!("{}: cannot write", path.display()))?;
    let cases = held_out(args, progress)?;
    let judged =
        cases.iter().map(|case| Judged::of(case, &chooser, &settings, progress)).collect::<Result<Vec<_>>>()?;
    Ok(vec![error_table(&judged, examples.len())])
}

/// Errors of one picture that was held out.
struct Judged {
    name: String,
    rule: Comparison,
    learned: Comparison,
}

impl Judged {
    fn of(case: &Case, chooser: &Chooser, settings: &Settings, progress: &Progress) -> Result<Self> {
        progress.say(&format!("{}: held out", case.name));
        let rebuilt = |chooser| -> Result<Comparison> {
            let rebuilt = reconstruct_with_chooser(&case.stack, &settings.reconstruction, chooser, progress)?;
            case.judge(&rebuilt.picture)
        };
        Ok(Self { name: case.name.clone(), rule: rebuilt(None)?, learned: rebuilt(Some(chooser))? })
    }

    fn row(&self) -> Vec<String> {
        let Self { name, rule, learned } = self;
        let values = [
            rule.rmse_cross,
            learned.rmse_cross,
            self.ratio(|c| c.rmse_cross),
            rule.rmse_cross_trimmed,
            learned.rmse_cross_trimmed,
            self.ratio(|c| c.rmse_cross_trimmed),
            rule.energy_ratio,
            learned.energy_ratio,
        ];
        std::iter::once(name.clone()).chain(values.map(maybe)).collect()
    }

    /// The network's error over that of the rule.
    fn ratio(&self, error: fn(&Comparison) -> Option<f64>) -> Option<f64> {
        Some(error(&self.learned)? / error(&self.rule)?)
    }
}

fn error_table(judged: &[Judged], examples: usize) -> Table {
    let head = ["held out", "rule", "learned", "learned ÷ rule", "rule, trimmed", "learned, trimmed", "trimmed ÷"];
    let head: Vec<&str> = head.into_iter().chain(["energy, rule", "energy, learned"]).collect();
    let mut table = Table::new(format!("Cross rMSE of held-out pictures; trained on {examples} others"), &head);
    table.rows = judged.iter().map(Judged::row).collect();
    let mean = |error| maybe(geometric_mean(judged.iter().map(|judged| judged.ratio(error))));
    let (all, trimmed) = (mean(|c| c.rmse_cross), mean(|c| c.rmse_cross_trimmed));
    let [none, gap] = ["geometric mean", "-"].map(String::from);
    let mean = [&none, &gap, &gap, &all, &gap, &gap, &trimmed, &gap, &gap];
    table.rows.push(mean.into_iter().cloned().collect());
    table
}
