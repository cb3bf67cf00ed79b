//! What each stage is worth: the error with every stage switched off in turn.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use reconstruct::metrics::{Comparison, Reference, compare};
use reconstruct::{Reconstruction, reconstruct};
use stack::file::{read_buckets, read_picture};
use stack::{FeatureStack, Image, Knobs};

use super::table::{Table, maybe};
use crate::args::ExperimentArgs;
use crate::failure::usage;
use crate::progress::Progress;
use crate::settings::Settings;

/// A name and the flags that make it.
type Variant = (&'static str, &'static [(&'static str, &'static str)]);

const VARIANTS: [Variant; 17] = [
    ("paper", &[]),
    ("no spike removal", &[("spike-removal", "false")]),
    ("spike threshold × log-average", &[("spike-threshold-unit", "log-average")]),
    ("spikes by 20 iterations × log-average", &[("spike-threshold-unit", "log-average"), ("spike-iterations", "20")]),
    ("no prefilter", &[("prefilter-filter", "off")]),
    ("pixel prefilter", &[("prefilter-filter", "pixel")]),
    ("prefilter's variance from all buckets", &[("prefilter-variance-from", "buckets")]),
    ("plain SVD, no robust PCA", &[("reduce-method", "svd")]),
    ("robust PCA by 1 iteration", &[("reduce-iterations", "1")]),
    ("robust PCA on every pixel of the window", &[("reduce-stride", "1")]),
    ("rank by energy alone (k₁)", &[("reduce-rank", "energy")]),
    ("rank by perturbation alone (k₂)", &[("reduce-rank", "perturbation")]),
    ("no reduction (all directions)", &[("reduce-method", "svd"), ("reduce-energy", "1")]),
    ("no normalisation in the window", &[("window-normalise", "none")]),
    ("fixed bandwidth h = 1", &[("bandwidth-fixed", "1")]),
    ("no curvature (b = 1)", &[("curvature-adaptive", "false")]),
    ("window 11×11", &[("window-radius", "5")]),
];

/// A stack of buckets with two references.
struct Case {
    name: String,
    stack: FeatureStack,
    references: [Image; 2],
}

/// Runs the experiment on every folder given.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let cases: Vec<Case> = args.inputs.iter().map(|folder| open(folder)).collect::<Result<_>>()?;
    let mut head = vec!["variant"];
    head.extend(cases.iter().map(|case| case.name.as_str()));
    let mut table = Table::new("Cross rMSE, trimmed cross rMSE, energy", &head);
    let mut noisy = vec!["noisy".to_string()];
    noisy.extend(cases.iter().map(|case| cell(&case.judge(&case.stack.beauty()))));
    table.rows.push(noisy);
    let mut histograms = Vec::new();
    for (name, flags) in VARIANTS {
        let settings = settings(flags)?;
        let mut row = vec![name.to_string()];
        for case in &cases {
            progress.say(&format!("{}: {name}", case.name));
            let outcome = reconstruct(&case.stack, &settings.reconstruction, progress)?;
            row.push(cell(&case.judge(&outcome.picture)));
            if flags.is_empty() {
                histograms.extend(histogram(case, &outcome));
            }
        }
        table.rows.push(row);
    }
    histograms.insert(0, table);
    Ok(histograms)
}

fn settings(flags: &[(&str, &str)]) -> Result<Settings> {
    let mut settings = Settings::default();
    for (flag, value) in flags {
        settings.set(flag, value).ok_or_else(|| usage(format!("no setting is called {flag}")))??;
    }
    Ok(settings)
}

fn open(folder: &Path) -> Result<Case> {
    let buckets: Vec<PathBuf> =
        (0..).map(|b| folder.join(format!("b{b}.exr"))).take_while(|file| file.exists()).collect();
    let name = folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let read = read_buckets(&buckets).with_context(|| format!("{}: b0.exr, b1.exr …", folder.display()))?;
    let references = [read_picture(&folder.join("ref1.exr"))?, read_picture(&folder.join("ref2.exr"))?];
    Ok(Case { name, stack: read.stack, references })
}

impl Case {
    fn judge(&self, picture: &Image) -> Comparison {
        let reference = Reference { second: Some(&self.references[1]), ..Reference::new(&self.references[0]) };
        compare(picture, &reference).unwrap_or_default()
    }
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
