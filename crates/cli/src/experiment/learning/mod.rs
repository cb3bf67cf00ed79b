//! Trains the learning-based filter on variations of our scenes, and judges it on pictures it has not seen, beside the
//! best filter whose bandwidths are the same everywhere.

pub mod held_out;
pub mod training_set;
pub mod variation;
pub mod versus;

use anyhow::Result;
use reconstruct::metrics::Comparison;
use reconstruct::rivals::lbf::training::{TrainingSettings, best_fixed, train};
use reconstruct::rivals::lbf::{Bandwidths, Network, Tuning};
use reconstruct::rivals::{self, Rival};
use stack::Image;

use super::case::Case;
use crate::args::ExperimentArgs;
use crate::exposure;
use crate::output::write_with_png;
use crate::progress::Progress;
use crate::settings::Settings;
use crate::table::Table;
use held_out::held_out;
use training_set::training_set;
use versus::{Versus, versus_table, write_weights};

/// How the network is trained, but for window and seed.
const TRAINING: TrainingSettings =
    TrainingSettings { radius: 10, epochs: 16, rows: 96, rate: 0.01, decay: 0.01, seed: 0 };

/// Runs the experiment; writes the weights to `weights.txt` in its folder.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let settings = args.settings()?;
    let examples = training_set(args, progress)?;
    let radius = settings.reconstruction.lbf.radius;
    let fixed = best_fixed(&examples, radius, progress)?;
    let training = TrainingSettings { radius, seed: settings.trace.seed, ..TRAINING };
    let network = train(&examples, fixed, &training, progress)?;
    write_weights(args, &network.to_text())?;
    let judged: Vec<Versus> = held_out(args, progress)?
        .iter()
        .map(|case| judge(case, fixed, &network, &settings, args, progress))
        .collect::<Result<_>>()?;
    let title = format!("Cross rMSE of held-out pictures; fixed bandwidths {fixed:.3?}");
    Ok(vec![versus_table(title, ["fixed", "lbf"], &judged)])
}

/// Errors of one picture that was held out; writes the pictures.
fn judge(
    case: &Case,
    fixed: Bandwidths,
    network: &Network,
    settings: &Settings,
    args: &ExperimentArgs,
    progress: &Progress,
) -> Result<Versus> {
    progress.say(&format!("{}: held out", case.name));
    let filtered = |tuning, name: &str| -> Result<Comparison> {
        let rebuilt = rivals::reconstruct(&case.stack, Rival::Lbf(tuning), &settings.reconstruction, progress)?;
        keep(case, &rebuilt.picture, name, args)?;
        case.judge(&rebuilt.picture)
    };
    keep(case, &case.references[0], "reference", args)?;
    Ok(Versus {
        name: case.name.clone(),
        noisy: Some(case.judge(&case.stack.beauty())?),
        plain: filtered(Tuning::Fixed(fixed), "fixed")?,
        learned: filtered(Tuning::Network(network), "lbf")?,
    })
}

fn keep(case: &Case, picture: &Image, name: &str, args: &ExperimentArgs) -> Result<()> {
    let file = args.output.join(format!("{}-{name}.exr", case.name.replace(' ', "-")));
    write_with_png(&file, picture, exposure::choose(&case.references[0]))
}
