//! Trains the network that helps to mix candidates on variations of our scenes and on rooms of chance, and judges it on
//! pictures it has not seen, beside the rule without it.

mod examples;
mod room;

use anyhow::Result;
use reconstruct::best::Chooser;
use reconstruct::best::training::{TrainingSettings, train};
use reconstruct::metrics::Comparison;
use reconstruct::reconstruct_with_chooser;

use super::case::Case;
use super::learning::held_out::held_out;
use super::learning::versus::{Versus, versus_table, write_weights};
use crate::args::ExperimentArgs;
use crate::progress::Progress;
use crate::settings::Settings;
use crate::table::Table;

/// How the network is trained, but for the seed.
const TRAINING: TrainingSettings = TrainingSettings { steps: 600, blocks: 32, rate: 0.01, decay: 1e-4, seed: 0 };

/// Runs the experiment; writes the weights to `weights.txt` in its folder.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let settings = args.settings()?;
    let examples = examples::examples(args, progress)?;
    let chooser = train(&examples, &TrainingSettings { seed: settings.trace.seed, ..TRAINING }, progress)?;
    write_weights(args, &chooser.to_text())?;
    let cases = held_out(args, progress)?;
    let judged = cases.iter().map(|case| judge(case, &chooser, &settings, progress)).collect::<Result<Vec<_>>>()?;
    let title = format!("Cross rMSE of held-out pictures; trained on {} others", examples.len());
    Ok(vec![versus_table(title, ["rule", "learned"], &judged)])
}

/// Errors of one picture that was held out.
fn judge(case: &Case, chooser: &Chooser, settings: &Settings, progress: &Progress) -> Result<Versus> {
    progress.say(&format!("{}: held out", case.name));
    let rebuilt = |chooser| -> Result<Comparison> {
        let rebuilt = reconstruct_with_chooser(&case.stack, &settings.reconstruction, chooser, progress)?;
        case.judge(&rebuilt.picture)
    };
    Ok(Versus { name: case.name.clone(), noisy: None, plain: rebuilt(None)?, learned: rebuilt(Some(chooser))? })
}
