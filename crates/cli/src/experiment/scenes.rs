//! Noisy, uniform and adaptive pictures of whole scenes.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use reconstruct::metrics::{Comparison, Reference, compare};
use stack::{Image, Window};
use tracer::camera::Camera;
use tracer::film::Film;

use super::reference::reference;
use super::table::{Table, maybe, short};
use crate::args::ExperimentArgs;
use crate::output::write_png;
use crate::progress::Progress;
use crate::render::{Budget, Finished, Sampling, View, open_scene, trace_adaptively};
use crate::settings::Settings;

/// A scene with its camera.
pub struct Stage {
    pub name: String,
    pub view: View,
    pub camera: Camera,
}

impl Stage {
    /// Opens a scene at the experiment's size.
    pub fn open(file: &Path, args: &ExperimentArgs, progress: &Progress) -> Result<Self> {
        let view = open_scene(file, progress)?;
        let camera = view.camera(args.size.0)?;
        let name = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        Ok(Self { name, view, camera })
    }

    /// Renders it.
    pub fn render(&self, settings: &Settings, budget: &Budget, rebuild: bool, progress: &Progress) -> Result<Finished> {
        let film = Film::new(Window::whole(self.camera.film), self.camera.film, &settings.trace);
        let sampling = Sampling { scene: &self.view.scene, camera: &self.camera, settings, progress };
        let finished = trace_adaptively(&sampling, film, budget, rebuild)?;
        if finished.interrupted { Err(stack::Cancelled.into()) } else { Ok(finished) }
    }
}

/// Runs the experiment on every scene given.
pub fn run(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Table>> {
    let head =
        ["scene", "spp", "picture", "seconds", "rMSE", "trimmed", "energy", "estimated rMSE", "most / median spp"];
    let mut table = Table::new(format!("Scenes at {}, against {} spp", args.size.0, args.reference_spp), &head);
    for file in &args.inputs {
        let stage = Stage::open(file, args, progress)?;
        let truth = reference(args, &stage, progress)?;
        for spp in &args.spp {
            for (name, uniform, rebuild) in [("noisy", true, false), ("uniform", true, true), ("adaptive", false, true)]
            {
                progress.say(&format!("{}: {name} at {spp} spp", stage.name));
                let start = Instant::now();
                let budget = Budget { uniform, ..Budget::uniform(*spp) };
                let finished = stage.render(&Settings::default(), &budget, rebuild, progress)?;
                let seconds = start.elapsed().as_secs_f64();
                let picture = finished.picture();
                write_png(
                    &args.output.join(format!("{}-{spp}-{name}.png", stage.name)),
                    &picture,
                    stage.exposure(&truth),
                )?;
                table.rows.push(row(&stage.name, *spp, name, seconds, &finished, &judge(&picture, &truth)));
            }
        }
        write_png(&args.output.join(format!("{}-reference.png", stage.name)), &truth, stage.exposure(&truth))?;
    }
    Ok(vec![table])
}

/// Measures `picture` against one reference.
pub fn judge(picture: &Image, truth: &Image) -> Comparison {
    compare(picture, &Reference::new(truth)).unwrap_or_default()
}

impl Stage {
    fn exposure(&self, truth: &Image) -> f32 {
        crate::exposure::choose(truth)
    }
}

fn row(scene: &str, spp: u32, name: &str, seconds: f64, finished: &Finished, c: &Comparison) -> Vec<String> {
    let estimated = finished.rounds.last().and_then(|round| round.estimated_rmse);
    let mut counts = finished.stack.samples.total.clone();
    counts.sort_unstable();
    let median = f64::from(counts[counts.len() / 2]);
    let spread = f64::from(counts[counts.len() - 1]) / median;
    vec![
        scene.into(),
        spp.to_string(),
        name.into(),
        format!("{seconds:.1}"),
        maybe(c.rmse),
        maybe(c.rmse_trimmed),
        maybe(c.energy_ratio),
        maybe(estimated),
        short(spread),
    ]
}
