//! `tamis experiment`: the tables of the documentation, made again by one command each.

mod calibration;
mod case;
mod changes;
mod chooser;
mod degrade;
mod errormap;
mod figures;
mod fireflies;
mod geometric_mean;
mod guide;
mod learning;
mod methods;
pub mod name;
mod oidn;
mod reference;
mod scenes;
mod sequences;
mod stage;
mod stages;

use anyhow::{Context, Result};
use clap::ValueEnum;

use crate::args::ExperimentArgs;
use crate::failure::{Verdict, usage};
use crate::interrupt;
use crate::progress::Progress;
use crate::stdout::print_line;
use crate::threads::start_threads;
use name::Experiment;

/// Runs the command.
pub fn run(args: &ExperimentArgs) -> Result<Verdict> {
    if args.inputs.is_empty() && args.name.needs_inputs() {
        return Err(usage("this experiment needs inputs; tamis help experiment says which"));
    }
    changes::check(args)?;
    start_threads(&args.report)?;
    interrupt::listen();
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("{}: cannot make the folder", args.output.display()))?;
    let progress = Progress::new(&args.report);
    let tables = match args.name {
        Experiment::Stages => stages::run(args, &progress)?,
        Experiment::Methods => methods::run(args, &progress)?,
        Experiment::Scenes => scenes::run(args, &progress)?,
        Experiment::Sequences => sequences::run(args, &progress)?,
        Experiment::Errormap => errormap::run(args, &progress)?,
        Experiment::Figures => figures::run(args, &progress)?,
        Experiment::Degrade => degrade::run(args, &progress)?,
        Experiment::Guide => guide::run(args, &progress)?,
        Experiment::Fireflies => fireflies::run(&progress)?,
        Experiment::Lbf => learning::run(args, &progress)?,
        Experiment::Chooser => chooser::run(args, &progress)?,
    };
    progress.finish();
    let name = args.name.to_possible_value().map_or_else(String::new, |value| value.get_name().to_string());
    let text: String = tables.iter().map(|table| format!("{table}\n")).collect();
    let path = args.output.join(format!("{name}.md"));
    std::fs::write(&path, &text).with_context(|| format!("{}: cannot write", path.display()))?;
    print_line(text.trim_end())?;
    Ok(Verdict::Done)
}
