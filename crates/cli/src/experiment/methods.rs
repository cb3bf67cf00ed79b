//! Every method on every stack, and against Open Image Denoise.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use reconstruct::metrics::Comparison;
use reconstruct::reconstruct;
use stack::Image;
use stack::file::{Carried, ResultLayer, StackHeader, write_stack};

use super::case::{Case, Entry, settings};
use super::geometric_mean::geometric_mean;
use super::oidn::{self, NAMES};
use super::reference::references;
use super::stage::Stage;
use crate::args::ExperimentArgs;
use crate::exposure;
use crate::output::write_with_png;
use crate::progress::Progress;
use crate::settings::Preset;
use crate::table::{Table, maybe};

/// Every method there is, and `best` for all light at once.
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
    ("whole", Preset::Best, &[("light-apart", "false")]),
    ("fast", Preset::Fast, &[]),
];

/// Methods that are not ours: published ones, and other programs.
const RIVALS: [&str; 8] = ["wlr", "wlrp", "wlrv", "nfor", "apr", "lbf", "oidn", "oidn-clean"];

/// A judged picture of one stack.
struct Cell {
    method: &'static str,
    comparison: Comparison,
    /// Time of the reconstruction; nobody knows how long another program took.
    seconds: Option<f64>,
}

/// Runs the experiment on every folder and scene given.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let head = ["stack", "method", "cross rMSE", "trimmed", "FLIP", "SSIM", "energy", "seconds"];
    let mut table = Table::new("Methods", &head);
    let mut judged = Vec::new();
    let mut take = |case: &Case| -> Result<()> {
        let cells = judge(case, args, progress)?;
        table.rows.extend(cells.iter().map(|cell| row(&case.name, cell)));
        judged.push(cells);
        Ok(())
    };
    for input in &args.inputs {
        if input.is_dir() {
            take(&beside_oidn(Case::open(input)?, input, args)?)?;
        } else {
            let stage = Stage::open(input, args, progress)?;
            let references = references(args, &stage, progress)?;
            for (spp, seed) in args.spp.iter().flat_map(|spp| (0..args.seeds).map(move |seed| (*spp, seed))) {
                take(&rendered(&stage, &references, (spp, seed), args, progress)?)?;
            }
        }
    }
    let ratios = [("Open Image Denoise's", &NAMES[..]), ("the best rival's", &RIVALS[..])];
    Ok(std::iter::once(table).chain(ratios.iter().filter_map(|(whose, rivals)| over(whose, rivals, &judged))).collect())
}

/// A folder's case, with what the program that was given makes of it.
fn beside_oidn(mut case: Case, input: &Path, args: &ExperimentArgs) -> Result<Case> {
    if let Some(command) = &args.oidn {
        case.others = oidn::denoise(command, input, &args.output)?;
    }
    Ok(case)
}

/// Uniform samples of a scene, kept as a stack in the experiment's folder.
fn rendered(
    stage: &Stage,
    references: &[Image; 2],
    (spp, seed): (u32, u64),
    args: &ExperimentArgs,
    progress: &Progress,
) -> Result<Case> {
    let mut settings = args.settings()?;
    settings.trace.seed = seed;
    let name = format!("{}-{spp}spp-{seed}", stage.name);
    progress.say(&format!("{name}: samples"));
    let stack = stage.sample(&settings, spp, progress)?;
    let file = args.output.join(format!("{name}.exr"));
    let header = StackHeader::of(&stack, settings.to_json());
    let picture = stack.beauty();
    let picture = ResultLayer { name: "", channels: &["R", "G", "B"], planes: picture.channels() };
    write_stack(&file, &stack, true, &header, &[picture], &Carried::default())?;
    beside_oidn(Case { name, stack, references: references.clone(), others: Vec::new() }, &file, args)
}

/// All methods on one stack, other programs last; writes their pictures.
fn judge(case: &Case, args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Cell>> {
    let stops = exposure::choose(&case.references[0]);
    let keep = |name: &str, picture: &Image| -> Result<()> {
        write_with_png(&args.output.join(format!("{}-{name}.exr", case.name)), picture, stops)
    };
    keep("reference", &case.references[0])?;
    let mut cells = Vec::new();
    for (method, preset, flags) in METHODS {
        progress.say(&format!("{}: {method}", case.name));
        let mut settings = settings(*preset, flags)?;
        args.change(&mut settings)?;
        let start = Instant::now();
        let picture = reconstruct(&case.stack, &settings.reconstruction, progress)?.picture;
        let seconds = Some(start.elapsed().as_secs_f64());
        keep(method, &picture)?;
        cells.push(Cell { method, comparison: case.judge(&picture)?, seconds });
    }
    for (name, picture) in &case.others {
        keep(name, picture)?;
        cells.push(Cell { method: name, comparison: case.judge(picture)?, seconds: None });
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

/// Every method's errors over the least of the `rivals'`, error by error: geometric means over the stacks that some rival
/// that was not made here has a picture of, and the largest trimmed one. `None` when there is no such stack.
fn over(whose: &str, rivals: &[&str], judged: &[Vec<Cell>]) -> Option<Table> {
    let compared: Vec<&Vec<Cell>> =
        judged.iter().filter(|cells| cells.iter().any(|cell| NAMES.contains(&cell.method))).collect();
    let title = format!("Errors over {whose}, geometric mean (stacks: {})", compared.len());
    let mut table = Table::new(title, &["method", "cross rMSE", "trimmed", "FLIP", "1 − SSIM", "worst trimmed"]);
    for (method, ..) in METHODS {
        let ratios: Vec<[Option<f64>; 4]> = compared.iter().map(|cells| ratios(cells, method, rivals)).collect();
        let mean = |error: usize| maybe(geometric_mean(ratios.iter().map(|ratios| ratios[error])));
        let worst = ratios.iter().filter_map(|ratios| ratios[1]).reduce(f64::max);
        table.rows.push(
            std::iter::once((*method).to_string())
                .chain((0..4).map(mean))
                .chain(std::iter::once(maybe(worst)))
                .collect(),
        );
    }
    (!compared.is_empty()).then_some(table)
}

/// Errors of `method` over the least of the `rivals'`. A rival whose measure is not above 0, by chance, does not count.
fn ratios(cells: &[Cell], method: &str, rivals: &[&str]) -> [Option<f64>; 4] {
    let own = cells.iter().find(|cell| cell.method == method);
    std::array::from_fn(|error| {
        let of_rivals = cells.iter().filter(|cell| rivals.contains(&cell.method));
        let least = of_rivals.filter_map(|cell| errors(&cell.comparison)[error].filter(|e| *e > 0.0)).reduce(f64::min);
        Some(errors(&own?.comparison)[error]? / least?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(method: &'static str, rmse_cross: f64, ssim: f64) -> Cell {
        let comparison = Comparison { rmse_cross: Some(rmse_cross), ssim: Some(ssim), ..Comparison::default() };
        Cell { method, comparison, seconds: None }
    }

    #[test]
    fn ratios_are_geometric_means_over_stacks_with_another_program() {
        let judged = [
            vec![cell("paper", 0.04, 0.6), cell("ld", -1.0, 0.5), cell("nfor", 0.005, 0.5), cell("oidn", 0.01, 0.9)],
            vec![cell("paper", 0.09, 0.8), cell("ld", 1.0, 0.5), cell("oidn-clean", 0.09, 0.6), cell("oidn", 0.2, 0.1)],
            vec![cell("paper", 1e9, 0.0), cell("ld", 1.0, 0.5)],
        ];
        let table = over("theirs", &NAMES, &judged).unwrap();
        assert!(table.title.contains("stacks: 2"), "{}", table.title);
        let row = |table: &Table, name: &str| table.rows.iter().find(|row| row[0] == name).unwrap().clone();
        assert_eq!(row(&table, "paper"), ["paper", "2.00", "-", "-", "1.41", "-"]);
        assert_eq!(row(&table, "ld"), ["ld", "-", "-", "-", "2.50", "-"]);
        let of_all = over("all", &RIVALS, &judged).unwrap();
        assert_eq!(row(&of_all, "paper")[1], "2.83", "the first stack's least is nfor's");
        assert!(over("theirs", &NAMES, &judged[2..]).is_none());
    }
}
