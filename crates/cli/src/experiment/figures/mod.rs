//! The paper's figures, made again as far as their parts exist: a table each, and pictures beside it.
//!
//! Figures 1 to 9 compare settings on the same samples, taken from a folder of buckets or rendered from a scene; which
//! settings, and what is measured, is in `list`. Figures 10 and 11 compare whole renders (`renders`).

mod features;
mod figure;
mod layers;
mod list;
mod measures;
mod outcome;
mod renders;
mod subject;

use anyhow::Result;

use crate::args::ExperimentArgs;
use crate::progress::Progress;
use crate::table::Table;
use list::FIGURES;
use outcome::Outcomes;
use subject::Subject;

/// Makes the figures that are wanted from every input.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let subjects = Subject::open_all(args, progress)?;
    let mut outcomes = Outcomes::default();
    let mut tables = Vec::new();
    for figure in FIGURES.iter().filter(|figure| figure.numbers.iter().any(|number| is_wanted(args, *number))) {
        tables.push(figure.make(&subjects, &mut outcomes, args, progress)?);
    }
    let staged: Vec<_> = subjects.iter().filter_map(|s| s.stage.as_ref().map(|stage| (s, stage))).collect();
    if is_wanted(args, 10) && !staged.is_empty() {
        tables.push(renders::convergence(&staged, args, progress)?);
    }
    if is_wanted(args, 11) && !staged.is_empty() {
        tables.push(renders::equal_samples(&staged, args, progress)?);
    }
    Ok(tables)
}

fn is_wanted(args: &ExperimentArgs, number: u32) -> bool {
    args.figures.is_empty() || args.figures.contains(&number)
}
