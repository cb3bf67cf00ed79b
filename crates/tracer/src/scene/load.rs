//! From a file to a scene.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use stack::file::extension;

use super::description::{Light, RawRender, SceneDescription, SkyDescription, Stand, read_description};
use super::environment_file::read_environment;
use super::find_file::find_file;
use super::gltf::{GltfFile, read_gltf};
use super::notes::Notes;
use super::obj::read_obj;
use super::textures::TextureFiles;
use super::{Dropped, Instance, Mesh, Placement, Scene, SceneError};
use crate::camera::CameraDescription;
use crate::environment::Environment;
use crate::light::DeltaLight;
use crate::material::Material;

/// A scene and what its files say besides.
#[derive(Debug)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// Cameras with their names, in the file's order; an OBJ file has none.
    pub cameras: Vec<(Option<String>, CameraDescription)>,
    /// Radiance up to which what emits is to be looked at rather than to light anything: 1, the white of a display, in glTF
    /// files; 0 elsewhere.
    pub glow: f32,
    /// What was missing or ignored, one sentence each.
    pub notes: Vec<String>,
    /// The `[render]` table, as written.
    pub render: Option<RawRender>,
    /// Seconds spent on the acceleration structure.
    pub build_seconds: f64,
    /// Triangles, counting those of every instance.
    pub triangles: usize,
    /// Triangles no ray can hit, left out.
    pub dropped: Dropped,
    /// Textures of materials that are missing or cannot be read.
    pub missing_textures: usize,
}

/// Loads the scene at `path`: an OBJ or glTF file by itself, or a `.toml` file that puts several together.
///
/// # Errors
/// When a file is missing, cannot be read, or holds a mistake; the error says where and what was expected.
pub fn load(path: &Path) -> Result<Loaded, SceneError> {
    if path.is_dir() {
        return Err(SceneError::IsFolder { path: path.into() });
    }
    match extension(path).as_str() {
        "obj" => load_obj(path),
        "gltf" | "glb" => load_gltf(path),
        "toml" => load_toml(path),
        _ if !path.exists() => Err(SceneError::Missing { path: path.into() }),
        _ => Err(SceneError::UnknownFormat { path: path.into() }),
    }
}

fn load_obj(path: &Path) -> Result<Loaded, SceneError> {
    let mut parts = Parts::default();
    let mesh = parts.mesh(path)?;
    parts.instances.push(Instance { mesh, placement: Placement::IDENTITY, motion: None });
    parts.finish(SceneDescription::default(), None)
}

fn load_gltf(path: &Path) -> Result<Loaded, SceneError> {
    let mut notes = Notes::default();
    let file = read_gltf(path, &mut notes)?;
    let GltfFile { meshes, instances, materials, delta_lights, cameras } = file;
    let parts = Parts { meshes, instances, materials, delta_lights, notes, files: HashMap::new() };
    let loaded = parts.finish(SceneDescription { cameras, ..SceneDescription::default() }, None)?;
    Ok(Loaded { glow: 1.0, ..loaded })
}

fn load_toml(path: &Path) -> Result<Loaded, SceneError> {
    let mut description = read_description(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut parts = Parts::default();
    for geometry in &description.geometry {
        let mesh = parts.mesh(&folder.join(&geometry.file))?;
        let instance = |stand: &Stand| Instance { mesh, placement: stand.placement, motion: stand.motion };
        parts.instances.extend(geometry.stands.iter().map(instance));
    }
    let mut textures = TextureFiles::new(folder);
    for change in std::mem::take(&mut description.material_changes) {
        change.apply(&mut parts.materials, &mut textures)?;
    }
    for (light, number) in std::mem::take(&mut description.lights).into_iter().zip(1..) {
        parts.light(light, number);
    }
    let environment = description.environment.take().map(|sky| parts.environment(folder, sky)).transpose()?;
    parts.finish(description, environment)
}

/// What a scene is made of, while files are read.
#[derive(Default)]
struct Parts {
    meshes: Vec<Mesh>,
    /// Which file each mesh came from.
    files: HashMap<PathBuf, usize>,
    instances: Vec<Instance>,
    materials: Vec<Material>,
    delta_lights: Vec<DeltaLight>,
    notes: Notes,
}

impl Parts {
    /// Index of the mesh in an OBJ or glTF file, which is read once.
    fn mesh(&mut self, path: &Path) -> Result<usize, SceneError> {
        if let Some(&index) = self.files.get(path) {
            return Ok(index);
        }
        let (mut mesh, mut materials) = match extension(path).as_str() {
            "gltf" | "glb" => self.gltf_mesh(path)?,
            "obj" => read_obj(path, &mut self.notes).map(|file| (file.mesh, file.materials))?,
            _ if path.exists() && !path.is_dir() => return Err(SceneError::UnknownFormat { path: path.into() }),
            _ => return Err(SceneError::Missing { path: path.into() }),
        };
        let first = self.materials.len() as u32;
        mesh.materials.iter_mut().for_each(|m| *m += first);
        self.materials.append(&mut materials);
        self.meshes.push(mesh);
        self.files.insert(path.into(), self.meshes.len() - 1);
        Ok(self.meshes.len() - 1)
    }

    /// All meshes of a glTF file as one. Cameras and lights are those of the scene that it is part of.
    fn gltf_mesh(&mut self, path: &Path) -> Result<(Mesh, Vec<Material>), SceneError> {
        let file = read_gltf(path, &mut self.notes)?;
        if !file.cameras.is_empty() || !file.delta_lights.is_empty() {
            self.notes.add(format!("{}: cameras and lights are left out, only meshes are taken", path.display()));
        }
        Ok(file.into_mesh())
    }

    fn light(&mut self, light: Light, number: usize) {
        match light {
            Light::Delta(light) => self.delta_lights.push(light),
            Light::Area(mut lamp) => {
                let material = self.materials.len() as u32;
                self.materials.push(lamp.material(format!("light {number}")));
                lamp.mesh.materials.fill(material);
                let stand = Instance { mesh: self.meshes.len(), placement: Placement::IDENTITY, motion: None };
                self.instances.push(stand);
                self.meshes.push(lamp.mesh);
            }
        }
    }

    /// The sky; its map's file is looked for in `folder`.
    fn environment(&mut self, folder: &Path, sky: SkyDescription) -> Result<Environment, SceneError> {
        match sky {
            SkyDescription::Constant(radiance) => Ok(Environment::constant(radiance)),
            SkyDescription::Map { file, rotate, scale } => {
                let found = find_file(folder, &file.to_string_lossy()).unwrap_or_else(|| folder.join(&file));
                let (environment, note) = read_environment(&found)?;
                note.into_iter().for_each(|note| self.notes.add(note));
                Ok(environment.turned_to(rotate).scaled(scale))
            }
        }
    }

    fn finish(self, description: SceneDescription, environment: Option<Environment>) -> Result<Loaded, SceneError> {
        let start = Instant::now();
        let mut scene = Scene::new(self.meshes, self.instances, self.materials, environment)?;
        scene.delta_lights = self.delta_lights;
        let mut notes = self.notes;
        scene.dropped().said().into_iter().for_each(|note| notes.add(note));
        Ok(Loaded {
            build_seconds: start.elapsed().as_secs_f64(),
            triangles: scene.triangles(),
            dropped: scene.dropped(),
            missing_textures: notes.missing_textures(),
            scene,
            cameras: description.cameras,
            glow: 0.0,
            notes: notes.into_lines(),
            render: description.render,
        })
    }
}

#[cfg(test)]
mod tests;
