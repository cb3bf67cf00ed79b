//! What each stage is worth: the error with every stage switched off in turn.

use anyhow::Result;
use reconstruct::metrics::Comparison;
use reconstruct::{Reconstruction, reconstruct};

use super::case::{Case, Flags, settings};
use crate::args::ExperimentArgs;
use crate::progress::Progress;
use crate::settings::Preset;
use crate::table::{Table, maybe};

/// A name and the flags that make it of the paper's settings.
type Variant = (&'static str, Flags);

const VARIANTS: &[Variant] = &[
    ("paper", &[]),
    ("no spike removal", &[("spike-removal", "false")]),
    ("spike threshold × log-average", &[("spike-threshold-unit", "log-average")]),
    ("spikes by 20 iterations × log-average", &[("spike-threshold-unit", "log-average"), ("spike-iterations", "20")]),
    ("spikes, low-rank part first", &[("spike-order", "low-rank-first")]),
    ("spikes with half of λ", &[("spike-lambda", "0.5")]),
    ("spikes as LBF finds them", &[("spike-method", "lbf")]),
    ("no prefilter", &[("prefilter-filter", "off")]),
    ("pixel prefilter", &[("prefilter-filter", "pixel")]),
    ("non-local-means prefilter", &[("prefilter-filter", "nl-means")]),
    ("no visibility", &[("prefilter-visibility", "false")]),
    ("prefilter's variance from all buckets", &[("prefilter-variance-from", "buckets")]),
    ("plain SVD, no robust PCA", &[("reduce-method", "svd")]),
    ("robust PCA by 1 iteration", &[("reduce-iterations", "1")]),
    ("robust PCA by 30 iterations", &[("reduce-iterations", "30"), ("reduce-tolerance", "0")]),
    ("robust PCA, low-rank part first", &[("reduce-order", "a-first")]),
    ("robust PCA, λ = 3/√n", &[("reduce-lambda", "three-over-root")]),
    ("robust PCA, λ = 1/√d", &[("reduce-lambda", "shortest-side")]),
    ("robust PCA on every pixel of the window", &[("reduce-stride", "1")]),
    ("rank by energy alone (k₁)", &[("reduce-rank", "energy")]),
    ("rank by perturbation alone (k₂)", &[("reduce-rank", "perturbation")]),
    ("rank by squares of singular values", &[("reduce-energy-of", "squares")]),
    ("no reduction (all directions)", &[("reduce-method", "svd"), ("reduce-energy", "1")]),
    ("no normalisation in the window", &[("window-normalise", "none")]),
    ("fixed bandwidth h = 1", &[("bandwidth-fixed", "1")]),
    ("no curvature (b = 1)", &[("curvature-adaptive", "false")]),
    ("window 11×11", &[("window-radius", "5")]),
];

/// Runs the experiment on every folder given.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let cases = Case::open_all(args)?;
    let mut head = vec!["variant"];
    head.extend(cases.iter().map(|case| case.name.as_str()));
    let mut table = Table::new("Cross rMSE, trimmed cross rMSE, energy", &head);
    let mut noisy = vec!["noisy".to_string()];
    for case in &cases {
        noisy.push(cell(&case.judge(&case.stack.beauty())?));
    }
    table.rows.push(noisy);
    let mut histograms = Vec::new();
    for (name, flags) in VARIANTS {
        let settings = settings(Preset::Paper, flags)?;
        let mut row = vec![name.to_string()];
        for case in &cases {
            progress.say(&format!("{}: {name}", case.name));
            let outcome = reconstruct(&case.stack, &settings.reconstruction, progress)?;
            row.push(cell(&case.judge(&outcome.picture)?));
            if flags.is_empty() {
                histograms.extend(histogram(case, &outcome));
            }
        }
        table.rows.push(row);
    }
    histograms.insert(0, table);
    Ok(histograms)
}

fn cell(c: &Comparison) -> String {
    format!("{} / {} / {}", maybe(c.rmse_cross), maybe(c.rmse_cross_trimmed), maybe(c.energy_ratio))
}

/// Shares of pixels per rank, and deciles of the bandwidth.
fn histogram(case: &Case, outcome: &Reconstruction) -> Option<Table> {
    let (rank, bandwidth) = (outcome.rank.as_ref()?, outcome.bandwidth.as_ref()?);
    let mut table =
        Table::new(format!("{}: rank k and bandwidth h", case.name), &["", "", "", "", "", "", "", "", "", "", ""]);
    let pixels = rank.len() as f64;
    table.head[0] = "k".into();
    let mut shares = vec!["share".to_string()];
    for k in 1..=10 {
        table.head[k] = k.to_string();
        let share = rank.iter().filter(|rank| **rank == k as f32).count() as f64 / pixels;
        shares.push(format!("{:.1} %", 100.0 * share));
    }
    table.rows.push(shares);
    let mut sorted = bandwidth.clone();
    sorted.sort_by(f32::total_cmp);
    let decile = |i: usize| format!("{:.3}", sorted[(sorted.len() - 1) * i / 9]);
    table.rows.push(std::iter::once("deciles of h".to_string()).chain((0..10).map(decile)).collect());
    Some(table)
}
