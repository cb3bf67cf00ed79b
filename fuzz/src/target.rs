//! What is fed, and to whom.

use std::path::Path;
use std::{fs, io};

use stack::file::{Inputs, Layers, ReadOptions, read_inputs, read_render, read_stack, survey};
use stack::{Silent, Size, Window};
use tempfile::TempDir;
use tracer::camera::CameraDescription;
use tracer::film::Film;
use tracer::integrator::{TraceSettings, trace};
use tracer::scene::{load, read_environment};

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    Obj,
    Gltf,
    Mtl,
    Toml,
    Exr,
    Hdr,
    Picture,
    Pfm,
}

/// What its file is called, and which files must lie beside it, from which place in `corpus`.
struct Setting {
    name: &'static str,
    file: &'static str,
    beside: &'static [(&'static str, &'static str)],
}

impl Target {
    const ALL: [Self; 8] =
        [Self::Obj, Self::Gltf, Self::Mtl, Self::Toml, Self::Exr, Self::Hdr, Self::Picture, Self::Pfm];

    const fn setting(self) -> Setting {
        const PICTURE: (&str, &str) = ("a.png", "picture/a.png");
        const SKY: (&str, &str) = ("sky.hdr", "hdr/runs.hdr");
        let (name, file, beside): (_, _, &'static [_]) = match self {
            Self::Obj => ("obj", "a.obj", &[("a.mtl", "mtl/materials.mtl"), PICTURE]),
            // Binaries are told apart by content.
            Self::Gltf => ("gltf", "a.gltf", &[PICTURE]),
            Self::Mtl => ("mtl", "a.mtl", &[("a.obj", "obj/materials.obj"), PICTURE]),
            Self::Toml => {
                ("toml", "a.toml", &[("a.obj", "obj/materials.obj"), ("a.mtl", "mtl/materials.mtl"), PICTURE, SKY])
            }
            Self::Exr => ("exr", "a.exr", &[]),
            Self::Hdr => ("hdr", "a.hdr", &[]),
            // Formats are told apart by content, but for TGA, which is recognised by nothing else.
            Self::Picture => ("picture", "a.tga", &[]),
            Self::Pfm => ("pfm", "a.pfm", &[]),
        };
        Setting { name, file, beside }
    }

    /// What it is called on the command line and in `corpus`.
    pub fn name(self) -> &'static str {
        self.setting().name
    }

    /// What its file is called.
    pub fn file(self) -> &'static str {
        self.setting().file
    }

    /// All names.
    pub fn names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }

    /// The target of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|target| target.name() == name)
    }

    /// A folder with all but the file itself.
    pub fn prepare(self, home: &Path) -> io::Result<TempDir> {
        let folder = tempfile::tempdir()?;
        for (name, source) in self.setting().beside {
            fs::copy(home.join("corpus").join(source), folder.path().join(name))?;
        }
        Ok(folder)
    }

    /// Reads the file in `folder`, and looks at what it shows.
    ///
    /// # Errors
    /// In words, why it cannot be read.
    pub fn read(self, folder: &Path) -> Result<(), String> {
        match self {
            // Tables of rough glass, made when a ray first meets it, would take most of the time.
            Self::Mtl => load(&folder.join("a.obj")).map(|_| ()).map_err(|error| error.to_string()),
            Self::Obj => show(&folder.join("a.obj")),
            Self::Gltf | Self::Toml => show(&folder.join(self.file())),
            Self::Exr | Self::Pfm => {
                let file = folder.join(self.file());
                let sky = sky(&file);
                weigh(&file);
                Layers::read(&file).map_err(|error| error.to_string()).and(sky)
            }
            Self::Hdr | Self::Picture => sky(&folder.join(self.file())),
        }
    }

    /// Bytes of memory that an input of `length` bytes may take: what may be needed for the emptiest one, and a share of the
    /// best compression its format has.
    pub const fn allowed_bytes(self, length: usize) -> usize {
        let (least, each) = match self {
            Self::Obj | Self::Gltf | Self::Mtl | Self::Toml => (8 << 20, 4 << 10),
            Self::Hdr => (8 << 20, 1 << 10),
            Self::Pfm => (8 << 20, 64),
            Self::Picture => (32 << 20, 32 << 10),
            // DWA: two deflated bytes for a block of 8 × 8 floats, which are held up to four times.
            Self::Exr => (64 << 20, 576 << 10),
        };
        least + each * length
    }
}

/// Reads a map of the sky.
fn sky(file: &Path) -> Result<(), String> {
    read_environment(file).map(|_| ()).map_err(|error| error.to_string())
}

/// Reads a stack, when there is one, in every way there is, and looks at its noise.
fn weigh(file: &Path) {
    let options = ReadOptions::default();
    let surveyed = survey(&Inputs::Files(vec![file.into()]), &options).is_ok();
    let stacks = [read_stack(file).ok(), read_render(file).ok().map(|(read, _)| read)];
    // Two slices that overlap, so that their headers are compared and no more.
    let slices = read_inputs(&Inputs::Slices(vec![file.into(), file.into()]), &options).ok();
    for read in stacks.into_iter().chain([slices]).flatten() {
        assert!(surveyed, "what can be read can be surveyed");
        let counts = &read.stack.samples;
        for component in &read.stack.components {
            let _ = (component.radiance.variance_of_mean(counts), component.radiance.halves(counts));
        }
    }
}

/// Loads a scene and traces a few paths through it.
fn show(file: &Path) -> Result<(), String> {
    let loaded = load(file).map_err(|error| error.to_string())?;
    let size = Size::new(4, 4);
    let bounds = loaded.scene.bounds();
    let eye = bounds.centre() + (bounds.max - bounds.min);
    let cameras = loaded.cameras.iter().map(|(_, camera)| *camera);
    for camera in cameras.chain([CameraDescription::looking(eye, bounds.centre())]) {
        let Ok(camera) = camera.on(size) else { continue };
        let settings = TraceSettings { max_depth: 4, ..TraceSettings::DEFAULT };
        let mut film = Film::new(Window::whole(size), size, &settings);
        let map = film.next_samples(1);
        let traced = trace(&loaded.scene, &camera, &mut film, &map, &settings, &Silent);
        traced.expect("a film with a fitting map can be traced");
    }
    Ok(())
}
