//! `tamis bench`: how fast this machine traces and reconstructs, beside what it can do at all and beside what it did before.
//!
//! Seconds depend on the machine and on what else it does. So every step is measured in turn with all others, several times
//! over, and its best round counts; and beside the others stands a plain copy, the least that a machine can do.

mod earlier;
mod measures;
mod room;
mod steps;

use anyhow::Result;
use serde_json::json;

use crate::args::BenchArgs;
use crate::failure::{Verdict, usage};
use crate::progress::Progress;
use crate::stdout::print_line;
use crate::threads::start_threads;
use earlier::Earlier;
use measures::Measures;
use steps::Steps;

/// Runs the command.
pub fn run(args: &BenchArgs) -> Result<Verdict> {
    if let Some(loss) = args.max_loss.filter(|loss| !(0.0..1.0).contains(loss)) {
        return Err(usage(format!("--max-loss: expected a share from 0 to below 1, found {loss}")));
    }
    start_threads(&args.report)?;
    let progress = Progress::new(&args.report);
    let earlier = args.against.as_deref().map(Earlier::read).transpose()?;
    let mut report = json!({"scene": args.scene, "size": [args.size.0.width, args.size.0.height], "spp": args.spp});
    earlier.iter().try_for_each(|earlier| earlier.check_work(&report))?;
    let steps = Steps::new(args, &progress)?;
    let mut measures = Measures::default();
    for round in 1..=args.rounds {
        progress.whisper(&format!("round {round} of {}", args.rounds));
        steps.measure(&mut measures, &progress)?;
    }
    progress.finish();
    let ratios = earlier.map(|earlier| earlier.ratios(&measures));
    if args.report.json {
        report["threads"] = rayon::current_num_threads().into();
        report["rounds"] = args.rounds.into();
        report["measures"] = measures.to_json();
        report["against"] = json!(ratios);
        print_line(report)?;
    } else {
        print_line(measures.table(ratios.as_ref()))?;
    }
    let lost = |loss: f64| ratios.iter().flat_map(|ratios| ratios.values()).any(|ratio| *ratio < 1.0 - loss);
    Ok(if args.max_loss.is_some_and(lost) { Verdict::No } else { Verdict::Done })
}
