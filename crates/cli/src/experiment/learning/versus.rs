//! What training brought: errors with what was learned beside errors without.

use anyhow::{Context, Result};
use reconstruct::metrics::Comparison;

use crate::args::ExperimentArgs;
use crate::experiment::geometric_mean::geometric_mean;
use crate::table::{Table, maybe};

/// Writes the weights to `weights.txt` in the experiment's folder.
///
/// # Errors
/// When it cannot be written.
pub fn write_weights(args: &ExperimentArgs, text: &str) -> Result<()> {
    let path = args.output.join("weights.txt");
    std::fs::write(&path, text).with_context(|| format!("{}: cannot write", path.display()))
}

/// Errors of one picture that was held out.
pub struct Versus {
    pub name: String,
    /// Of the samples as they are, where that is shown.
    pub noisy: Option<Comparison>,
    /// Without what was learned.
    pub plain: Comparison,
    pub learned: Comparison,
}

impl Versus {
    fn row(&self) -> Vec<String> {
        let Self { name, noisy, plain, learned } = self;
        let values = [
            plain.rmse_cross,
            learned.rmse_cross,
            self.ratio(|c| c.rmse_cross),
            plain.rmse_cross_trimmed,
            learned.rmse_cross_trimmed,
            self.ratio(|c| c.rmse_cross_trimmed),
            plain.energy_ratio,
            learned.energy_ratio,
        ];
        let noisy = noisy.iter().map(|noisy| noisy.rmse_cross);
        std::iter::once(name.clone()).chain(noisy.chain(values).map(maybe)).collect()
    }

    /// The error with what was learned over that without.
    fn ratio(&self, error: fn(&Comparison) -> Option<f64>) -> Option<f64> {
        Some(error(&self.learned)? / error(&self.plain)?)
    }
}

/// All of `judged` with the geometric means of their ratios; `names` are those of what is plain and what is learned.
pub fn versus_table(title: String, [plain, learned]: [&str; 2], judged: &[Versus]) -> Table {
    let gap = || "-".to_string();
    let noisy = judged.iter().any(|versus| versus.noisy.is_some());
    let mean = |error| maybe(geometric_mean(judged.iter().map(|versus| versus.ratio(error))));
    // Each column with its entry in the last row.
    let mut columns = vec![("held out".to_string(), "geometric mean".to_string())];
    columns.extend(noisy.then(|| ("noisy".to_string(), gap())));
    columns.extend([
        (plain.to_string(), gap()),
        (learned.to_string(), gap()),
        (format!("{learned} ÷ {plain}"), mean(|c| c.rmse_cross)),
        (format!("{plain}, trimmed"), gap()),
        (format!("{learned}, trimmed"), gap()),
        ("trimmed ÷".to_string(), mean(|c| c.rmse_cross_trimmed)),
        (format!("energy, {plain}"), gap()),
        (format!("energy, {learned}"), gap()),
    ]);
    let (head, last): (Vec<String>, Vec<String>) = columns.into_iter().unzip();
    Table { title, head, rows: judged.iter().map(Versus::row).chain([last]).collect() }
}
