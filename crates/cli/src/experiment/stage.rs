//! A scene of an experiment, with its camera.

use std::path::Path;

use anyhow::Result;
use stack::{FeatureStack, Window};
use tracer::camera::Camera;
use tracer::film::Film;

use crate::args::ExperimentArgs;
use crate::progress::Progress;
use crate::render::{Budget, Finished, Sampling, View, open_scene, trace_adaptively};
use crate::settings::Settings;

/// This project's own scenes, from its folder.
pub const OWN_SCENES: [&str; 3] = ["scenes/study.toml", "scenes/halves.toml", "scenes/defocus.toml"];

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
        let sampling = Sampling {
            scene: &self.view.scene,
            camera: &self.camera,
            settings,
            progress,
            preview: None,
            checkpoint: None,
        };
        let finished = trace_adaptively(&sampling, film, budget, rebuild)?;
        if finished.interrupted { Err(stack::Cancelled.into()) } else { Ok(finished) }
    }

    /// Traces `spp` samples for every pixel and rebuilds nothing.
    pub fn sample(&self, settings: &Settings, spp: u32, progress: &Progress) -> Result<FeatureStack> {
        Ok(self.render(settings, &Budget::uniform(spp), false, progress)?.stack)
    }
}
