//! glTF 2.0 files (Khronos Group 2021), as JSON with files beside it or as one binary.
//!
//! The `gltf` crate reads the JSON and checks that its indices point somewhere. What the bytes hold is read here (`buffers`,
//! `numbers`), for they may be anything; `primitives` makes meshes of it, `materials` and `placed_textures` surfaces, and
//! `nodes` puts everything in its place. Units are the scene's own: lights' candela and lux, and emission's candela per
//! square metre, are taken for intensity, irradiance and radiance as they stand.

mod binary;
mod buffers;
mod instancing;
mod materials;
mod nodes;
mod numbers;
mod placed_textures;
mod pose;
mod poses;
mod primitives;

use std::path::Path;

use gltf::json::Root;
use gltf::json::validation::{Checked, Error, Validate};

use super::notes::Notes;
use super::source::read_bytes;
use super::{Instance, Mesh, SceneError};
use crate::camera::CameraDescription;
use crate::light::DeltaLight;
use crate::material::{Grey, Material};
use binary::parts_of;
use buffers::Buffers;
use materials::read_materials;
use nodes::Stage;
use primitives::read_meshes;

/// What a glTF file holds.
#[derive(Debug)]
pub(super) struct GltfFile {
    /// What stands in the scene; triangles of a mesh that stands there several times are here once.
    pub(super) meshes: Vec<Mesh>,
    /// Where it stands.
    pub(super) instances: Vec<Instance>,
    /// What `meshes` index.
    pub(super) materials: Vec<Material>,
    /// Cameras with their names.
    pub(super) cameras: Vec<(Option<String>, CameraDescription)>,
    /// Lights that no ray can hit.
    pub(super) delta_lights: Vec<DeltaLight>,
}

/// Extensions that are heeded, or that say nothing about what is rendered here.
const KNOWN: [&str; 14] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
];

/// Reads a `.gltf` or `.glb` file and those it names: its scene, as it stands before anything moves. What is missing or not
/// heeded but not vital goes to `notes`.
///
/// # Errors
/// When a file is missing or cannot be read, something points to what there is not, or there is nothing to see.
pub(super) fn read_gltf(path: &Path, notes: &mut Notes) -> Result<GltfFile, SceneError> {
    let refused = |reason: String| SceneError::BadGltf { path: path.into(), reason };
    let bytes = read_bytes(path)?;
    if bytes.is_empty() {
        return Err(SceneError::EmptyFile { path: path.into() });
    }
    let (json, blob) = parts_of(&bytes).map_err(refused)?;
    let root: Root = Root::from_slice(json).map_err(|error| refused(format!("its JSON has a mistake: {error}")))?;
    check(&root).map_err(refused)?;
    let document = gltf::Document::from_json_without_validation(root);
    note_unknown(document.as_json(), path, notes);
    let folder = path.parent().unwrap_or(Path::new(""));
    let buffers = Buffers::read(&document, blob, folder).map_err(|reason| match reason {
        buffers::Missing::File(path) => SceneError::Missing { path },
        buffers::Missing::Other(reason) => refused(reason),
    })?;
    let (mut materials, needs) = read_materials(&document, &buffers, folder, notes);
    let meshes = read_meshes(&document, &buffers, &needs, path, notes).map_err(refused)?;
    forget_idle_opacity(&meshes, &mut materials);
    // Those for primitives without, where there are none.
    let used = meshes.iter().flat_map(|mesh| &mesh.materials).map(|m| *m as usize + 1).max().unwrap_or(0);
    materials.truncate(used.max(document.materials().len()));
    let mut stage = Stage::new(meshes);
    stage.set(&document, &buffers, &needs, path, notes).map_err(refused)?;
    let Stage { meshes, instances, cameras, delta_lights } = stage;
    if instances.is_empty() {
        let vertices = meshes.iter().map(|mesh| mesh.positions.len()).sum();
        return Err(SceneError::NoFaces { path: path.into(), vertices });
    }
    Ok(GltfFile { meshes, instances, materials, cameras, delta_lights })
}

/// Where neither a material nor the vertices that show it let any ray through, it is opaque: that is quicker.
fn forget_idle_opacity(meshes: &[Mesh], materials: &mut [Material]) {
    let mut veiled = vec![false; materials.len()];
    for mesh in meshes.iter().filter(|mesh| mesh.colours.iter().any(|colour| colour.w < 1.0)) {
        for (triangle, material) in mesh.triangles.iter().zip(&mesh.materials) {
            veiled[*material as usize] |= triangle.iter().any(|&v| mesh.colours[v as usize].w < 1.0);
        }
    }
    for (material, _) in materials.iter_mut().zip(veiled).filter(|(_, veiled)| !veiled) {
        let least = |opacity: &Grey| opacity.factor * opacity.texture.as_ref().map_or(1.0, |map| map.range()[0]);
        let maps = &mut material.maps;
        if maps.opacity.as_ref().is_none_or(|opacity| least(opacity) >= maps.cutoff.unwrap_or(1.0)) {
            (maps.opacity, maps.cutoff) = (None, None);
        }
    }
}

impl GltfFile {
    /// All that stands in the scene, as one mesh.
    pub(super) fn into_mesh(self) -> (Mesh, Vec<Material>) {
        let mut all = Mesh::default();
        for instance in self.instances {
            all.append(self.meshes[instance.mesh].clone().moved(&instance.placement));
        }
        (all, self.materials)
    }
}

/// Checks that everything points somewhere and that no extension is needed that is not known.
fn check(root: &Root) -> Result<(), String> {
    if let Some(needed) = root.extensions_required.iter().find(|name| !KNOWN.contains(&name.as_str())) {
        return Err(format!("needs the extension {needed}, which is not supported; {}", remedy(needed)));
    }
    // Geometry may be there twice, compressed and not; or only compressed, whatever the file says of need.
    if let Some(compressed) = compressed_only(root) {
        return Err(format!(
            "has geometry that only {compressed} holds, which is not supported; {}",
            remedy(compressed)
        ));
    }
    // What the crate takes for granted while it checks.
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let mut positions = primitives.filter_map(|one| one.attributes.get(&Checked::Valid(gltf::Semantic::Positions)));
    if let Some(accessor) = positions.find(|accessor| accessor.value() >= root.accessors.len()) {
        return Err(format!("accessors[{}], which positions are to be in, is not there", accessor.value()));
    }
    let mut wrong = None;
    root.validate(root, gltf::json::Path::new, &mut |path, error| {
        // Bounds are of no use here, and exporters forget them; extensions were looked at above.
        let is_bound = [".min", ".max"].iter().any(|end| path().as_str().ends_with(end));
        if wrong.is_none() && !is_bound && error != Error::Unsupported {
            wrong = Some((path(), error));
        }
    });
    let Some((place, error)) = wrong else { return Ok(()) };
    Err(match error {
        Error::IndexOutOfBounds => format!("{place} points to something that is not there"),
        Error::Missing => format!("{place} is missing"),
        Error::Oversize => format!("{place} is too large for this machine"),
        Error::Invalid | Error::Unsupported => format!("{place} has a value that cannot be"),
    })
}

/// What to do about an extension that a file cannot be read without.
fn remedy(extension: &str) -> String {
    match extension {
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "unpack it with gltfpack -i IN.glb -o OUT.glb -noq, or export it without compression".into()
        }
        DRACO => "open it in Blender and export it without compression".into(),
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" | "MSFT_texture_dds" => {
            "export it with textures in PNG or JPEG".into()
        }
        _ => "export it without".into(),
    }
}

const VARIANTS: &str = "KHR_materials_variants";
const DRACO: &str = "KHR_draco_mesh_compression";

/// An extension that alone holds some of the geometry.
fn compressed_only(root: &Root) -> Option<&'static str> {
    let position = Checked::Valid(gltf::Semantic::Positions);
    let mut primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let only_draco = primitives.any(|one| {
        let has_draco = one.extensions.as_ref().is_some_and(|all| all.others.contains_key(DRACO));
        let accessor = one.attributes.get(&position).and_then(|accessor| root.accessors.get(accessor.value()));
        has_draco && accessor.is_some_and(|accessor| accessor.buffer_view.is_none())
    });
    only_draco.then_some(DRACO)
}

fn note_unknown(root: &Root, path: &Path, notes: &mut Notes) {
    for name in root.extensions_used.iter().filter(|name| !KNOWN.contains(&name.as_str())) {
        notes.add(format!("{}: the extension {name} is not supported and ignored", path.display()));
    }
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    if primitives.filter_map(|one| one.extensions.as_ref()).any(|all| all.others.contains_key(VARIANTS)) {
        notes.add(format!("{}: of the variants of materials, the usual one is shown", path.display()));
    }
    if !root.animations.is_empty() {
        notes.add(format!("{}: animations are ignored; everything stands as it is placed", path.display()));
    }
}

#[cfg(test)]
mod tests;
