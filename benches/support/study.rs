//! The study scene, ready to be traced.

use stack::{FeatureStack, Silent, Size, Window};
use tracer::camera::Camera;
use tracer::film::Film;
use tracer::integrator::{TraceReport, TraceSettings, trace};
use tracer::scene::{Scene, load};

/// `scenes/study.toml` seen through its camera.
pub struct Study {
    scene: Scene,
    camera: Camera,
    size: Size,
}

impl Study {
    /// With a film of `size`.
    pub fn new(size: Size) -> Self {
        let loaded = load(&super::file("scenes/study.toml")).expect("the study scene is part of the repository");
        let camera = loaded.cameras[0].1.on(size).expect("its camera is sound");
        Self { scene: loaded.scene, camera, size }
    }

    /// Takes `spp` samples of every pixel.
    pub fn trace(&self, spp: u32) -> (Film, TraceReport) {
        let mut film = Film::new(Window::whole(self.size), self.size, &TraceSettings::DEFAULT);
        let map = film.next_samples(spp);
        let traced = trace(&self.scene, &self.camera, &mut film, &map, &TraceSettings::DEFAULT, &Silent);
        (film, traced.expect("nobody cancels"))
    }

    /// A stack of `spp` samples per pixel.
    pub fn stack(&self, spp: u32) -> FeatureStack {
        self.trace(spp).0.to_stack()
    }
}
