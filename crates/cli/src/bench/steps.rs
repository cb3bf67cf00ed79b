//! What is measured.

use std::hint::black_box;
use std::time::Instant;

use anyhow::Result;
use glam::Vec3;
use reconstruct::{Method, reconstruct};
use stack::{FeatureStack, Size, Window};
use tracer::Ray;
use tracer::camera::Camera;
use tracer::film::Film;
use tracer::integrator::{TraceSettings, trace};
use tracer::scene::{Bounds, Scene};

use super::measures::Measures;
use super::room;
use crate::args::BenchArgs;
use crate::progress::Progress;
use crate::render::{View, open_scene};
use crate::settings::{Preset, Settings};

/// Rays of a round: enough that no cache remembers their paths.
const RAYS: u64 = 200_000;

/// Numbers that are copied from memory to memory.
const COPIED: usize = 1 << 24;

/// A scene, seen through a camera.
pub struct Steps {
    scene: Scene,
    camera: Camera,
    size: Size,
    spp: u32,
    /// Whether the scene is the room that is made here, whose tree can be made again.
    own: bool,
    stack: FeatureStack,
}

impl Steps {
    /// Opens the scene that is asked for.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub fn new(args: &BenchArgs, progress: &Progress) -> Result<Self> {
        let size = args.size.0;
        let (scene, camera) = match &args.scene {
            None => (room::scene(room::meshes())?, room::CAMERA.on(size)?),
            Some(file) => {
                let view = open_scene(file, progress)?;
                let camera = view.camera(size)?;
                let View { scene, .. } = view;
                (scene, camera)
            }
        };
        // What is made when a ray first needs it is no part of any round.
        let stack = traced(&scene, &camera, size, args.spp, progress)?.to_stack();
        Ok(Self { scene, camera, size, spp: args.spp, own: args.scene.is_none(), stack })
    }

    /// Does everything once.
    ///
    /// # Errors
    /// When it is interrupted.
    pub fn measure(&self, measures: &mut Measures, progress: &Progress) -> Result<()> {
        let (from, mut to) = (vec![1.0_f32; COPIED], vec![0.0_f32; COPIED]);
        let (seconds, ()) = timed(|| black_box(&mut to).copy_from_slice(black_box(&from)));
        measures.add("copy, one thread", "GB/s", 4e-9 * COPIED as f64, seconds);
        if self.own {
            let meshes = room::meshes();
            let (seconds, scene) = timed(|| room::scene(meshes));
            measures.add("tree", "million triangles/s", 1e-6 * scene?.triangles() as f64, seconds);
        }
        let rays = rays(self.scene.bounds());
        let millions = 1e-6 * rays.len() as f64;
        let (seconds, _) = timed(|| rays.iter().filter(|ray| black_box(self.scene.intersect(ray)).is_some()).count());
        measures.add("closest hit, one thread", "million rays/s", millions, seconds);
        let (seconds, _) = timed(|| rays.iter().filter(|ray| black_box(self.scene.occluded(ray))).count());
        measures.add("occlusion, one thread", "million rays/s", millions, seconds);
        let (seconds, film) = timed(|| traced(&self.scene, &self.camera, self.size, self.spp, progress));
        let samples = self.size.pixels() as f64 * f64::from(self.spp);
        film?;
        measures.add("path tracing", "million samples/s", 1e-6 * samples, seconds);
        for (name, settings) in [
            ("best", Settings::of(Preset::Best)),
            ("fast", Settings::of(Preset::Fast)),
            ("paper", Settings::of(Preset::Paper)),
            ("nfor", nfor()),
        ] {
            let (seconds, rebuilt) = timed(|| reconstruct(&self.stack, &settings.reconstruction, progress));
            rebuilt?;
            measures.add(name, "megapixels/s", 1e-6 * self.size.pixels() as f64, seconds);
        }
        Ok(())
    }
}

fn traced(scene: &Scene, camera: &Camera, size: Size, spp: u32, progress: &Progress) -> Result<Film> {
    let settings = TraceSettings::DEFAULT;
    let mut film = Film::new(Window::whole(size), size, &settings);
    let map = film.next_samples(spp);
    trace(scene, camera, &mut film, &map, &settings, progress)?;
    Ok(film)
}

fn nfor() -> Settings {
    let mut settings = Settings::default();
    settings.reconstruction.method.method = Method::Nfor;
    settings
}

fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let made = work();
    (start.elapsed().as_secs_f64(), made)
}

/// Rays from anywhere in the box to anywhere, always the same: the R₅ sequence (Roberts 2018), whose points fill five
/// dimensions evenly.
fn rays(bounds: Bounds) -> Vec<Ray> {
    // The root of x⁶ = x + 1.
    const ROOT: f64 = 1.134_724_138_401_519_5;
    let share = |ray: u64, dimension: i32| (ray as f64 * ROOT.powi(-dimension)).fract() as f32;
    let ray = |ray: u64| {
        let place = Vec3::new(share(ray, 1), share(ray, 2), share(ray, 3));
        let (up, turn) = (2.0 * share(ray, 4) - 1.0, glam::Vec2::from_angle(std::f32::consts::TAU * share(ray, 5)));
        let across = (1.0 - up * up).max(0.0).sqrt();
        let direction = Vec3::new(across * turn.x, up, across * turn.y);
        Ray { origin: bounds.min + bounds.extent() * place, direction, t_max: f32::INFINITY, time: 0.0 }
    };
    (1..=RAYS).map(ray).collect()
}
