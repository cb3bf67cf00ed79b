//! Every method on every stack, and against Open Image Denoise.

use std::time::Instant;

use anyhow::Result;
use reconstruct::metrics::Comparison;
use reconstruct::reconstruct;
use stack::Image;
use stack::file::write_picture;

use super::case::{Case, Entry, settings};
use super::geometric_mean::geometric_mean;
use super::table::{Table, maybe};
use crate::args::{ExperimentArgs, Preset};
use crate::exposure;
use crate::output::write_png;
use crate::progress::Progress;

/// Every method there is.
pub const METHODS: &[Entry] = &[
    ("ld", Preset::Paper, &[("method", "ld")]),
    ("wlr", Preset::Paper, &[("method", "wlr")]),
    ("wlrp", Preset::Paper, &[("method", "wlrp")]),
    ("wlrv", Preset::Paper, &[("method", "wlrv")]),
    ("nfor", Preset::Paper, &[("method", "nfor")]),
    ("apr", Preset::Paper, &[("method", "apr")]),
    ("lbf", Preset::Paper, &[("method", "lbf")]),
    ("paper", Preset::Paper, &[]),
    ("best", Preset::Best, &[]),
    ("fast", Preset::Fast, &[]),
];

/// The row that the others are divided by.
const RIVAL: &str = "oidn";

/// A judged picture of one stack.
struct Cell {
    method: &'static str,
    comparison: Comparison,
    /// Time of the reconstruction; nobody knows how long the rival took.
    seconds: Option<f64>,
}

/// Runs the experiment on every folder given.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let head = ["stack", "method", "cross rMSE", "trimmed", "FLIP", "SSIM", "energy", "seconds"];
    let mut table = Table::new("Methods", &head);
    let mut judged = Vec::new();
    for case in Case::open_all(args)? {
        let cells = judge(&case, args, progress)?;
        table.rows.extend(cells.iter().map(|cell| row(&case.name, cell)));
        judged.push(cells);
    }
    Ok(std::iter::once(table).chain(ratios(&judged)).collect())
}

/// All methods on one stack, the rival last; writes their pictures.
fn judge(case: &Case, args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Cell>> {
    let stops = exposure::choose(&case.references[0]);
    let keep = |name: &str, picture: &Image| -> Result<()> {
        let file = args.output.join(format!("{}-{name}.exr", case.name));
        write_png(&file.with_extension("png"), picture, stops)?;
        Ok(write_picture(&file, picture)?)
    };
    keep("reference", &case.references[0])?;
    let mut cells = Vec::new();
    for (method, preset, flags) in METHODS {
        progress.say(&format!("{}: {method}", case.name));
        let settings = settings(*preset, flags)?;
        let start = Instant::now();
        let picture = reconstruct(&case.stack, &settings.reconstruction, progress)?.picture;
        let seconds = Some(start.elapsed().as_secs_f64());
        keep(method, &picture)?;
        cells.push(Cell { method, comparison: case.judge(&picture)?, seconds });
    }
    if let Some(oidn) = &case.oidn {
        keep(RIVAL, oidn)?;
        cells.push(Cell { method: RIVAL, comparison: case.judge(oidn)?, seconds: None });
    }
    Ok(cells)
}

fn row(stack: &str, cell: &Cell) -> Vec<String> {
    let c = &cell.comparison;
    let measures = [c.rmse_cross, c.rmse_cross_trimmed, c.flip, c.ssim, c.energy_ratio, cell.seconds];
    [stack, cell.method].map(String::from).into_iter().chain(measures.map(maybe)).collect()
}

/// Errors, of which less is better.
fn errors(c: &Comparison) -> [Option<f64>; 4] {
    [c.rmse_cross, c.rmse_cross_trimmed, c.flip, c.ssim.map(|ssim| 1.0 - ssim)]
}

/// Geometric means of every method's errors over the rival's, over the stacks that have it. `None` when none has.
fn ratios(judged: &[Vec<Cell>]) -> Option<Table> {
    let pairs: Vec<(&Cell, &Cell)> = judged
        .iter()
        .filter_map(|cells| cells.iter().find(|cell| cell.method == RIVAL).map(|rival| (cells, rival)))
        .flat_map(|(cells, rival)| cells.iter().map(move |cell| (cell, rival)))
        .collect();
    let stacks = pairs.iter().filter(|(cell, _)| cell.method == RIVAL).count();
    let head = ["method", "cross rMSE", "trimmed", "FLIP", "1 − SSIM"];
    let mut table = Table::new(format!("Errors over {RIVAL}'s, geometric mean (stacks: {stacks})"), &head);
    for (method, ..) in METHODS {
        let of_method = pairs.iter().filter(|(cell, _)| cell.method == *method);
        let ratio = |(cell, rival): &(&Cell, &Cell), error: usize| {
            Some(errors(&cell.comparison)[error]? / errors(&rival.comparison)[error]?)
        };
        let mean = |error: usize| geometric_mean(of_method.clone().map(|pair| ratio(pair, error)));
        table.rows.push(std::iter::once((*method).to_string()).chain((0..4).map(|e| maybe(mean(e)))).collect());
    }
    (stacks > 0).then_some(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(method: &'static str, rmse_cross: f64, ssim: f64) -> Cell {
        let comparison = Comparison { rmse_cross: Some(rmse_cross), ssim: Some(ssim), ..Comparison::default() };
        Cell { method, comparison, seconds: None }
    }

    #[test]
    fn ratios_are_geometric_means_over_stacks_with_the_rival() {
        let judged = [
            vec![cell("paper", 0.04, 0.6), cell("ld", -1.0, 0.5), cell(RIVAL, 0.01, 0.9)],
            vec![cell("paper", 0.09, 0.8), cell("ld", 1.0, 0.5), cell(RIVAL, 0.09, 0.6)],
            vec![cell("paper", 1e9, 0.0), cell("ld", 1.0, 0.5)],
        ];
        let table = ratios(&judged).unwrap();
        assert!(table.title.contains("stacks: 2"), "{}", table.title);
        let row = |name: &str| table.rows.iter().find(|row| row[0] == name).unwrap().clone();
        assert_eq!(row("paper"), ["paper", "2.00", "-", "-", "1.41"]);
        assert_eq!(row("ld"), ["ld", "-", "-", "-", "2.50"]);
        assert!(ratios(&judged[2..]).is_none());
    }
}
