//! `tamis compare`: how far pictures are from a reference.

mod encoded_picture;
mod page;
mod reduced;
mod settings_found;
mod table;

use std::path::Path;

use anyhow::{Context, Result};
use reconstruct::metrics::{Comparison, Reference, compare};
use serde_json::{Value, json};

use crate::any_picture::read_any_picture;
use crate::args::CompareArgs;
use crate::failure::{Verdict, usage};
use crate::mask::read_mask;
use crate::spool::Spool;
use crate::stdout::print_line;
use page::{Page, Shown, check_page};
use reduced::Scale;
pub use settings_found::changed_settings;
use table::MeasureTable;

/// Runs the command.
pub fn run(args: &CompareArgs) -> Result<Verdict> {
    if !(args.epsilon > 0.0 && args.epsilon.is_finite()) {
        return Err(usage(format!("--epsilon: expected a number above 0, found {}", args.epsilon)));
    }
    args.html.as_deref().map(check_page).transpose()?;
    let mut spool = Spool::default();
    let outcome = run_on_files(args, &mut spool);
    spool.naming(outcome)
}

fn run_on_files(args: &CompareArgs, spool: &mut Spool) -> Result<Verdict> {
    let mask = args.mask.as_deref().map(|file| spool.path(file)).transpose()?;
    let mut read = |file: &Path| read_any_picture(&spool.path(file)?);
    let (picture, record) = read(&args.reference)?;
    let second = args.ref2.as_deref().map(&mut read).transpose()?;
    let mask = mask.map(|file| read_mask(&file, picture.size())).transpose()?;
    let reference = Reference {
        second: second.as_ref().map(|(picture, _)| picture),
        epsilon: args.epsilon,
        mask: mask.as_deref(),
        ..Reference::new(&picture)
    };
    let scale = args.html.as_ref().map(|_| Scale::of(&picture));
    let (mut measured, mut shown) = (Vec::new(), Vec::new());
    for file in &args.images {
        let (image, record) = read(file)?;
        let comparison = compare(&image, &reference).with_context(|| file.display().to_string())?;
        measured.push((file.as_path(), comparison));
        // Only what the page needs of it is kept while the next is read.
        shown.extend(scale.map(|scale| Shown::new(file, &image, &record, scale)).transpose()?);
    }
    let table = MeasureTable::of(&measured);
    if args.json {
        print_line(report(args, &measured))?;
    } else {
        print_line(&table)?;
    }
    if let (Some(file), Some(scale)) = (&args.html, scale) {
        let first = Shown::new(&args.reference, &picture, &record, scale)?;
        let second = args.ref2.as_deref().zip(second.as_ref());
        let second = second.map(|(file, (picture, record))| Shown::new(file, picture, record, scale)).transpose()?;
        Page { args, reference, scale, first, shown, second, table }.write(file)?;
    }
    let too_far = |c: &Comparison| above(c.rmse, args.max_rmse) || above(c.flip, args.max_flip);
    Ok(if measured.iter().any(|(_, comparison)| too_far(comparison)) { Verdict::No } else { Verdict::Done })
}

fn above(measure: Option<f64>, limit: Option<f64>) -> bool {
    matches!((measure, limit), (Some(measure), Some(limit)) if measure > limit || measure.is_nan())
}

fn report(args: &CompareArgs, measured: &[(&Path, Comparison)]) -> Value {
    // As it is shown: a name need not be text, which JSON demands.
    let name = |file: &Path| file.display().to_string();
    let images: Vec<Value> = measured
        .iter()
        .map(|(file, comparison)| {
            let mut entry = json!({ "file": name(file) });
            if let (Value::Object(entry), Value::Object(measures)) = (&mut entry, json!(comparison)) {
                entry.extend(measures);
            }
            entry
        })
        .collect();
    json!({
        "reference": name(&args.reference),
        "ref2": args.ref2.as_deref().map(name),
        "mask": args.mask.as_deref().map(name),
        "epsilon": args.epsilon,
        "images": images,
    })
}
