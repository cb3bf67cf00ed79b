//! Trains the learning-based filter on variations of our scenes, and judges it on pictures it has not seen, beside the
//! best filter whose bandwidths are the same everywhere.

mod held_out;
mod training_set;
mod variation;

use anyhow::{Context, Result};
use reconstruct::metrics::Comparison;
use reconstruct::rivals::lbf::training::{TrainingSettings, best_fixed, train};
use reconstruct::rivals::lbf::{Bandwidths, Network, Tuning};
use reconstruct::rivals::{self, Rival};
use stack::Image;
use stack::file::write_picture;

use super::case::Case;
use super::geometric_mean::geometric_mean;
use super::table::{Table, maybe};
use crate::args::ExperimentArgs;
use crate::exposure;
use crate::output::write_png;
use crate::progress::Progress;
use crate::settings::Settings;
use held_out::held_out;
use training_set::training_set;

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
    let path = args.output.join("weights.txt");
    std::fs::write(&path, network.to_text()).with_context(|| format!("{}: cannot write", path.display()))?;
    let judged: Vec<Judged> = held_out(args, progress)?
        .iter()
        .map(|case| Judged::of(case, fixed, &network, &settings, args, progress))
        .collect::<Result<_>>()?;
    Ok(vec![error_table(&judged, fixed)])
}

/// Errors of one picture that was held out.
struct Judged {
    name: String,
    noisy: Comparison,
    fixed: Comparison,
    learned: Comparison,
}

impl Judged {
    fn of(
        case: &Case,
        fixed: Bandwidths,
        network: &Network,
        settings: &Settings,
        args: &ExperimentArgs,
        progress: &Progress,
    ) -> Result<Self> {
        progress.say(&format!("{}: held out", case.name));
        let filtered = |tuning, name: &str| -> Result<Comparison> {
            let rebuilt = rivals::reconstruct(&case.stack, Rival::Lbf(tuning), &settings.reconstruction, progress)?;
            keep(case, &rebuilt.picture, name, args)?;
            case.judge(&rebuilt.picture)
        };
        keep(case, &case.references[0], "reference", args)?;
        Ok(Self {
            name: case.name.clone(),
            noisy: case.judge(&case.stack.beauty())?,
            fixed: filtered(Tuning::Fixed(fixed), "fixed")?,
            learned: filtered(Tuning::Network(network), "lbf")?,
        })
    }

    fn row(&self) -> Vec<String> {
        let Self { name, noisy, fixed, learned } = self;
        let values = [
            noisy.rmse_cross,
            fixed.rmse_cross,
            learned.rmse_cross,
            self.ratio(|c| c.rmse_cross),
            fixed.rmse_cross_trimmed,
            learned.rmse_cross_trimmed,
            self.ratio(|c| c.rmse_cross_trimmed),
            fixed.energy_ratio,
            learned.energy_ratio,
        ];
        std::iter::once(name.clone()).chain(values.map(maybe)).collect()
    }

    /// The network's error over that of the fixed filter.
    fn ratio(&self, error: fn(&Comparison) -> Option<f64>) -> Option<f64> {
        Some(error(&self.learned)? / error(&self.fixed)?)
    }
}

fn keep(case: &Case, picture: &Image, name: &str, args: &ExperimentArgs) -> Result<()> {
    let file = args.output.join(format!("{}-{name}.exr", case.name.replace(' ', "-")));
    write_png(&file.with_extension("png"), picture, exposure::choose(&case.references[0]))?;
    Ok(write_picture(&file, picture)?)
}

fn error_table(judged: &[Judged], fixed: Bandwidths) -> Table {
    let head = ["held out", "noisy", "fixed", "lbf", "lbf ÷ fixed", "fixed, trimmed", "lbf, trimmed", "trimmed ÷"];
    let head: Vec<&str> = head.into_iter().chain(["energy, fixed", "energy, lbf"]).collect();
    let title = format!("Cross rMSE of held-out pictures; fixed bandwidths {fixed:.3?}");
    let mut table = Table::new(title, &head);
    table.rows = judged.iter().map(Judged::row).collect();
    let mean = |error| maybe(geometric_mean(judged.iter().map(|judged| judged.ratio(error))));
    let [none, gap] = ["geometric mean", "-"].map(String::from);
    let (all, trimmed) = (mean(|c| c.rmse_cross), mean(|c| c.rmse_cross_trimmed));
    let mean = [&none, &gap, &gap, &gap, &all, &gap, &gap, &trimmed, &gap, &gap];
    table.rows.push(mean.into_iter().cloned().collect());
    table
}
