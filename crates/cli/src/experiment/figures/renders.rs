//! Figures 10 and 11: whole renders, sampled uniformly or where the method's own error estimate leads.

use std::time::Instant;

use anyhow::Result;
use reconstruct::metrics::Comparison;

use super::subject::Subject;
use crate::args::ExperimentArgs;
use crate::experiment::case::{Entry, settings};
use crate::experiment::methods::METHODS;
use crate::experiment::stage::Stage;
use crate::output::write_png;
use crate::progress::Progress;
use crate::render::{Budget, Finished};
use crate::settings::Preset;
use crate::table::{Table, maybe};

const LD: Entry = ("ld", Preset::Paper, &[("method", "ld")]);

/// Methods of figure 10, and whether they sample adaptively there: in the paper NFOR does not.
const CONVERGING: &[(Entry, bool)] = &[
    (LD, false),
    (("nfor", Preset::Paper, &[("method", "nfor")]), false),
    (("wlr", Preset::Paper, &[("method", "wlr")]), true),
    (("ours", Preset::Paper, &[]), true),
    (("best", Preset::Best, &[]), true),
];

/// A judged render.
struct Render {
    finished: Finished,
    seconds: f64,
    comparison: Comparison,
}

impl Render {
    fn make(
        (subject, stage): (&Subject, &Stage),
        (name, preset, flags): Entry,
        (spp, adaptive): (u32, bool),
        progress: &Progress,
    ) -> Result<Self> {
        progress.say(&format!("{}: {name} at {spp} spp, {}", stage.name, way(adaptive)));
        let (settings, start) = (settings(preset, flags)?, Instant::now());
        let budget = Budget { uniform: !adaptive, ..Budget::uniform(spp) };
        let finished = stage.render(&settings, &budget, true, progress)?;
        let seconds = start.elapsed().as_secs_f64();
        let comparison = subject.case.judge(&finished.picture())?;
        Ok(Self { finished, seconds, comparison })
    }
}

const fn way(adaptive: bool) -> &'static str {
    if adaptive { "adaptive" } else { "uniform" }
}

/// Figure 10: cross rMSE of every method at every number of samples.
pub fn convergence(staged: &[(&Subject, &Stage)], args: &ExperimentArgs, progress: &Progress) -> Result<Table> {
    let mut head: Vec<String> = ["input", "method", "samples"].map(String::from).to_vec();
    head.extend(args.spp.iter().map(|spp| format!("{spp} spp")));
    let mut table = Table { title: "Figure 10: cross rMSE by samples".into(), head, rows: Vec::new() };
    for place in staged {
        for (entry, adaptive) in CONVERGING {
            let mut row = [&place.1.name, entry.0, way(*adaptive)].map(String::from).to_vec();
            for spp in &args.spp {
                row.push(maybe(Render::make(*place, *entry, (*spp, *adaptive), progress)?.comparison.rmse_cross));
            }
            table.rows.push(row);
        }
    }
    Ok(table)
}

/// Figure 11: every method at the largest number of samples, uniform and led by its own error map, and no method at as
/// much time as ours takes.
pub fn equal_samples(staged: &[(&Subject, &Stage)], args: &ExperimentArgs, progress: &Progress) -> Result<Table> {
    let head = ["input", "method", "samples", "spp", "seconds", "cross rMSE", "trimmed", "SSIM", "energy"];
    let mut table = Table::new("Figure 11: methods at equal samples", &head);
    let spp = args.spp.iter().copied().max().unwrap_or(1);
    for place in staged {
        let (mut ours, mut plain) = (0.0, 0.0);
        for entry in METHODS {
            for adaptive in [false, true] {
                let render = Render::make(*place, *entry, (spp, adaptive), progress)?;
                write(*place, entry.0, adaptive, &render, args)?;
                table.rows.push(row(&place.1.name, (entry.0, adaptive), &render));
                match (entry.0, adaptive) {
                    ("ld", false) => plain = render.seconds,
                    ("paper", true) => ours = render.seconds,
                    _ => {}
                }
            }
        }
        let equal_time = (f64::from(spp) * ours / f64::max(plain, 1e-3)).round().max(1.0) as u32;
        let render = Render::make(*place, LD, (equal_time, false), progress)?;
        table.rows.push(row(&place.1.name, ("ld at the time of paper", false), &render));
    }
    Ok(table)
}

fn write(
    (subject, stage): (&Subject, &Stage),
    name: &str,
    adaptive: bool,
    render: &Render,
    args: &ExperimentArgs,
) -> Result<()> {
    let file = args.output.join(format!("figure11-{}-{name}-{}.png", stage.name, way(adaptive)));
    write_png(&file, &render.finished.picture(), subject.stops)
}

fn row(scene: &str, (method, adaptive): (&str, bool), render: &Render) -> Vec<String> {
    let c = &render.comparison;
    let (spp, ..) = render.finished.stack.samples.mean_min_max();
    let names = [scene, method, way(adaptive)].map(String::from).into_iter();
    let measures = [Some(spp), Some(render.seconds), c.rmse_cross, c.rmse_cross_trimmed, c.ssim, c.energy_ratio];
    names.chain(measures.map(maybe)).collect()
}
