//! A scene with the camera and the sky it is seen under, after flags and guesses.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use glam::Vec3;
use stack::Size;
use tracer::camera::{Camera, CameraDescription};
use tracer::environment::Environment;
use tracer::scene::{Loaded, RawRender, Scene, guess_camera, guess_environment, load, read_environment};

use crate::args::RenderArgs;
use crate::failure::usage;
use crate::options::{Sky, Triple};
use crate::progress::Progress;
use crate::report::counted;

/// A scene ready to be rendered.
pub struct View {
    pub scene: Scene,
    pub render: Option<RawRender>,
    pub load_seconds: f64,
    pub build_seconds: f64,
    /// Textures that are missing or cannot be read.
    pub missing_textures: usize,
    camera: CameraDescription,
}

impl View {
    /// The camera with a film of `size`.
    ///
    /// # Errors
    /// When a value of it is out of range.
    pub fn camera(&self, size: Size) -> Result<Camera> {
        Ok(self.camera.on(size)?)
    }

    /// The camera without a film.
    pub const fn description(&self) -> &CameraDescription {
        &self.camera
    }
}

/// Opens the scene with the flags that were given.
///
/// # Errors
/// When it cannot be loaded, or a flag does not fit it.
pub fn open(args: &RenderArgs, progress: &Progress) -> Result<View> {
    let start = Instant::now();
    let mut loaded = read(&args.scene, progress)?;
    set_sky(&mut loaded, args, progress)?;
    let camera = choose_camera(&loaded, args, progress)?;
    let (build_seconds, missing_textures) = (loaded.build_seconds, loaded.missing_textures);
    let load_seconds = start.elapsed().as_secs_f64() - build_seconds;
    Ok(View { scene: loaded.scene, render: loaded.render, load_seconds, build_seconds, missing_textures, camera })
}

/// Opens the scene in `file` as it is.
///
/// # Errors
/// When it cannot be loaded.
pub fn open_scene(file: &Path, progress: &Progress) -> Result<View> {
    open(&RenderArgs { scene: file.into(), ..RenderArgs::default() }, progress)
}

/// Loads a scene that the command line names.
///
/// # Errors
/// When it is not there or cannot be loaded.
pub fn load_named(file: &Path) -> Result<Loaded> {
    check_named(file)?;
    Ok(load(file)?)
}

/// Refuses what is not there. The tracer's own answer speaks of the file that names it, and here there is none.
fn check_named(file: &Path) -> Result<()> {
    if file.exists() { Ok(()) } else { Err(usage(format!("{}: no such file", file.display()))) }
}

fn read(file: &Path, progress: &Progress) -> Result<Loaded> {
    let loaded = load_named(file)?;
    for note in &loaded.notes {
        progress.say(note);
    }
    let (triangles, emitters) = (counted(loaded.triangles, "triangle"), loaded.scene.emitters.len());
    progress.whisper(&format!("{triangles}, of which {emitters} emit"));
    Ok(loaded)
}

fn set_sky(loaded: &mut Loaded, args: &RenderArgs, progress: &Progress) -> Result<()> {
    let Loaded { scene, glow, .. } = loaded;
    if let Some(sky) = &args.env {
        scene.environment = Some(given_sky(sky, progress)?);
    } else if let Some(guess) = guess_environment(scene, *glow) {
        scene.environment = Some(Environment::constant(guess.value));
        progress.say(&guess.line);
    }
    if let Some(degrees) = args.env_rotate {
        if !degrees.is_finite() {
            return Err(usage(format!("--env-rotate: expected an angle in degrees, found {degrees}")));
        }
        scene.environment = scene.environment.take().map(|sky| sky.turned_to(degrees));
    }
    if let Some(scale) = args.env_scale {
        if !(scale >= 0.0 && scale.is_finite()) {
            return Err(usage(format!("--env-scale: expected a factor of at least 0, found {scale}")));
        }
        scene.environment = scene.environment.take().map(|sky| sky.scaled(scale));
    }
    Ok(())
}

/// The sky that a flag names.
fn given_sky(sky: &Sky, progress: &Progress) -> Result<Environment> {
    match sky {
        Sky::Constant(radiance) => Ok(Environment::constant(Vec3::from(*radiance))),
        Sky::Map(file) => {
            check_named(file)?;
            let (environment, note) = read_environment(file)?;
            note.iter().for_each(|note| progress.say(note));
            Ok(environment)
        }
    }
}

/// The camera of the file that was asked for, or its first, or a guess; changed by single flags.
fn choose_camera(loaded: &Loaded, args: &RenderArgs, progress: &Progress) -> Result<CameraDescription> {
    let given = |triple: Option<Triple>| triple.map(|t| Vec3::from(t.0));
    let mut camera = match (named_camera(loaded, args)?, given(args.eye)) {
        (Some(camera), _) => camera,
        (None, Some(eye)) => CameraDescription::looking(eye, loaded.scene.bounds().centre()),
        (None, None) => {
            let guess = guess_camera(&loaded.scene);
            progress.say(&guess.line);
            guess.value
        }
    };
    camera.eye = given(args.eye).unwrap_or(camera.eye);
    camera.look_at = given(args.look_at).unwrap_or(camera.look_at);
    camera.up = given(args.up).unwrap_or(camera.up);
    camera.fov = args.fov.unwrap_or(camera.fov);
    camera.lens_radius = args.lens_radius.unwrap_or(camera.lens_radius);
    camera.focus_distance = args.focus_distance.or(camera.focus_distance);
    camera.shutter = args.shutter.map_or(camera.shutter, |shutter| shutter.0);
    camera.check()?;
    Ok(camera)
}

fn named_camera(loaded: &Loaded, args: &RenderArgs) -> Result<Option<CameraDescription>> {
    let Some(wanted) = &args.camera else { return Ok(loaded.cameras.first().map(|(_, camera)| *camera)) };
    let found = loaded.cameras.iter().find(|(name, _)| name.as_ref() == Some(wanted));
    let names = || loaded.cameras.iter().filter_map(|(name, _)| name.clone()).collect::<Vec<_>>().join(", ");
    match found {
        Some((_, camera)) => Ok(Some(*camera)),
        None if loaded.cameras.iter().all(|(name, _)| name.is_none()) => {
            Err(usage(format!("--camera: the scene has no camera '{wanted}', and none that has a name")))
        }
        None => Err(usage(format!("--camera: the scene has no camera '{wanted}'; it has: {}", names()))),
    }
}
