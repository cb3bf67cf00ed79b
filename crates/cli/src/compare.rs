//! `tamis compare`: how far pictures are from a reference.

use std::path::Path;

use anyhow::{Context, Result};
use reconstruct::metrics::{Comparison, Reference, compare};
use serde_json::{Value, json};
use stack::Image;
use stack::file::read_picture;

use crate::args::CompareArgs;
use crate::failure::{Verdict, usage};
use crate::mask::read_mask;
use crate::stdout::print_line;

/// Runs the command.
pub fn run(args: &CompareArgs) -> Result<Verdict> {
    if !(args.epsilon > 0.0 && args.epsilon.is_finite()) {
        return Err(usage(format!("--epsilon: expected a number above 0, found {}", args.epsilon)));
    }
    let reference = read_picture(&args.reference)?;
    let second = args.ref2.as_deref().map(read_picture).transpose()?;
    let mask = args.mask.as_deref().map(|file| read_mask(file, reference.size())).transpose()?;
    let reference = Reference {
        second: second.as_ref(),
        epsilon: args.epsilon,
        mask: mask.as_deref(),
        ..Reference::new(&reference)
    };
    let mut measured = Vec::new();
    for file in &args.images {
        measured.push((file.as_path(), measure(file, &reference)?));
    }
    if args.json {
        print_line(report(args, &measured))?;
    } else {
        print_line(table(&measured))?;
    }
    let too_far = |c: &Comparison| above(c.rmse, args.max_rmse) || above(c.flip, args.max_flip);
    Ok(if measured.iter().any(|(_, comparison)| too_far(comparison)) { Verdict::No } else { Verdict::Done })
}

fn above(measure: Option<f64>, limit: Option<f64>) -> bool {
    matches!((measure, limit), (Some(measure), Some(limit)) if measure > limit || measure.is_nan())
}

fn measure(file: &Path, reference: &Reference<'_>) -> Result<Comparison> {
    let image: Image = read_picture(file)?;
    compare(&image, reference).with_context(|| file.display().to_string())
}

fn report(args: &CompareArgs, measured: &[(&Path, Comparison)]) -> Value {
    let images: Vec<Value> = measured
        .iter()
        .map(|(file, comparison)| {
            let mut entry = json!({ "file": file });
            if let (Value::Object(entry), Value::Object(measures)) = (&mut entry, json!(comparison)) {
                entry.extend(measures);
            }
            entry
        })
        .collect();
    json!({
        "reference": args.reference,
        "ref2": args.ref2,
        "mask": args.mask,
        "epsilon": args.epsilon,
        "images": images,
    })
}

/// A column for each measure that was taken for any image, a row for each image.
fn table(measured: &[(&Path, Comparison)]) -> String {
    let rows: Vec<(String, Measures)> =
        measured.iter().map(|(file, comparison)| (file.display().to_string(), values(comparison))).collect();
    let Some((_, first)) = rows.first() else { return String::new() };
    let shown: Vec<usize> = (0..first.len()).filter(|i| rows.iter().any(|(_, row)| row[*i].1.is_some())).collect();
    let width = rows.iter().map(|(file, _)| file.len()).max().unwrap_or(0);
    let heads: String = shown.iter().map(|i| format!("  {:>18}", first[*i].0)).collect();
    let mut lines = vec![format!("{:width$}{heads}", "")];
    for (file, row) in &rows {
        let cells: String = shown.iter().map(|i| format!("  {:>18}", number(row[*i].1))).collect();
        lines.push(format!("{file:width$}{cells}"));
    }
    lines.join("\n")
}

/// Named measures; those that were not taken are `None`.
type Measures = Vec<(String, Option<f64>)>;

fn values(comparison: &Comparison) -> Measures {
    match json!(comparison) {
        Value::Object(measures) => measures.into_iter().map(|(name, value)| (name, value.as_f64())).collect(),
        _ => Vec::new(),
    }
}

fn number(value: Option<f64>) -> String {
    match value {
        None => "-".into(),
        Some(v) if v == 0.0 || (0.01..1e6).contains(&v.abs()) => format!("{v:.4}"),
        Some(v) => format!("{v:.4e}"),
    }
}
