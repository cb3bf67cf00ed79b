//! Pictures mixed with guides of many kinds: what other denoisers' help is worth, and that nobody's harm.

mod kinds;
mod lesson;

use anyhow::{Context, Result};
use reconstruct::blend::Pair;
use reconstruct::metrics::Comparison;
use reconstruct::{Reconstruction, reconstruct};
use stack::Image;
use stack::file::write_picture;

use self::kinds::{Kind, kinds};
use self::lesson::write_lesson;
use super::case::{Case, judged_by};
use super::geometric_mean::geometric_mean;
use crate::args::ExperimentArgs;
use crate::progress::Progress;
use crate::settings::Settings;
use crate::table::{Table, maybe, short};

/// One guide of one stack: errors, and how far it was followed.
struct Judged {
    kind: &'static str,
    without: Comparison,
    guide: Comparison,
    with: Comparison,
    mean_weight: f64,
}

/// Runs the experiment on every folder given; writes what is made without a guide beside what is made with each.
///
/// # Errors
/// When a folder cannot be read, or a stack not be rebuilt.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let head = ["stack", "guide", "without", "guide alone", "with", "with ÷ better", "trimmed ÷ better", "mean weight"];
    let mut table = Table::new("Pictures by other denoisers as guides", &head);
    let mut all = Vec::new();
    for folder in &args.inputs {
        let case = Case::open_poor(folder)?;
        progress.say(&format!("{}: rebuilt without a guide", case.name));
        let settings = args.settings()?;
        let rebuilt = reconstruct(&case.stack, &settings.reconstruction, progress)?;
        write_picture(&args.output.join(format!("{}-without.exr", case.name)), &rebuilt.picture)?;
        for kind in kinds(&case, &rebuilt.picture, progress)? {
            let judged = judge(&case, &rebuilt, kind, &settings, args, progress)?;
            table.rows.push(row(&case.name, &judged));
            all.push(judged);
        }
    }
    Ok(vec![table, by_kind(&all)])
}

/// The result of one guide; writes the picture.
fn judge(
    case: &Case,
    rebuilt: &Reconstruction,
    kind: Kind,
    settings: &Settings,
    args: &ExperimentArgs,
    progress: &Progress,
) -> Result<Judged> {
    let Kind { name, picture, references } = kind;
    let pair = Pair::new(&case.stack, rebuilt, &picture, &settings.reconstruction, progress)?;
    let found = pair.blended(settings.reconstruction.guide.strength)?;
    let file = args.output.join(format!("{}-{}.exr", case.name, name.replace(' ', "_")));
    write_picture(&file, &found.picture)?;
    let references = references.as_ref().unwrap_or(&case.references);
    write_lesson(&file.with_extension("lesson"), &pair, [&rebuilt.picture, &picture], references)?;
    let of = |picture: &Image| judged_by(picture, references).with_context(|| case.name.clone());
    Ok(Judged {
        kind: name,
        without: of(&rebuilt.picture)?,
        guide: of(&picture)?,
        with: of(&found.picture)?,
        mean_weight: found.mean_weight(),
    })
}

/// A picture's error over that of the better of the two it is made of, whole and trimmed. `None` where there is no error.
fn over_better(judged: &Judged) -> [Option<f64>; 2] {
    let measures = |c: &Comparison| [c.rmse_cross, c.rmse_cross_trimmed];
    let [without, guide, with] = [&judged.without, &judged.guide, &judged.with].map(measures);
    std::array::from_fn(|i| {
        let better = without[i]?.min(guide[i]?);
        (better > 0.0).then(|| with[i].map(|error| error / better))?
    })
}

fn row(stack: &str, judged: &Judged) -> Vec<String> {
    let pair = |c: &Comparison| format!("{} / {}", maybe(c.rmse_cross), maybe(c.rmse_cross_trimmed));
    let pictures = [&judged.without, &judged.guide, &judged.with].map(pair);
    let ratios = over_better(judged).map(maybe);
    [stack, judged.kind]
        .map(String::from)
        .into_iter()
        .chain(pictures)
        .chain(ratios)
        .chain([short(judged.mean_weight)])
        .collect()
}

/// The same over all stacks.
fn by_kind(all: &[Judged]) -> Table {
    let head = ["guide", "stacks", "with ÷ better", "worst", "trimmed ÷ better", "worst", "with ÷ without, trimmed"];
    let mut table =
        Table::new("By guide, geometric mean over the stacks where the better of both has any error", &head);
    let mut names: Vec<&str> = all.iter().map(|judged| judged.kind).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let of_kind: Vec<&Judged> = all.iter().filter(|judged| judged.kind == name).collect();
        let mut row = vec![name.to_string(), of_kind.len().to_string()];
        for measure in 0..2 {
            let ratios: Vec<f64> = of_kind.iter().filter_map(|judged| over_better(judged)[measure]).collect();
            row.push(maybe(geometric_mean(ratios.iter().map(|ratio| Some(*ratio)))));
            row.push(maybe(ratios.into_iter().reduce(f64::max)));
        }
        let gain = |judged: &&Judged| Some(judged.with.rmse_cross_trimmed? / judged.without.rmse_cross_trimmed?);
        row.push(maybe(geometric_mean(of_kind.iter().map(gain))));
        table.rows.push(row);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(rmse_cross: f64, trimmed: f64) -> Comparison {
        Comparison { rmse_cross: Some(rmse_cross), rmse_cross_trimmed: Some(trimmed), ..Comparison::default() }
    }

    fn judged(guide: Comparison) -> Judged {
        Judged { kind: "oidn", without: errors(0.02, 0.01), guide, with: errors(0.01, 0.009), mean_weight: 0.5 }
    }

    #[test]
    fn the_better_of_both_is_what_counts() {
        assert_eq!(over_better(&judged(errors(0.04, 0.008))), [Some(0.5), Some(0.009 / 0.008)]);
        assert_eq!(over_better(&judged(errors(0.0, 0.0))), [None, None]);
    }

    #[test]
    fn stacks_are_put_together_by_guide() {
        let all = [judged(errors(0.04, 0.02)), judged(errors(0.04, 0.008)), judged(errors(0.0, 0.0))];
        let table = by_kind(&all);
        assert_eq!(table.rows.len(), 1);
        assert_eq!(table.rows[0][..4], ["oidn", "3", "0.5000", "0.5000"]);
        assert_eq!(table.rows[0][5], "1.12");
    }
}
