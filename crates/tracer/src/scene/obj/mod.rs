//! Wavefront OBJ files.
//!
//! `tobj` reads the numbers and unifies indices; [`polygon`] cuts faces into triangles. It gets the file line by line from
//! [`clean::CleanLines`], which mends what tobj 4 trips over and knows the line of every mistake.

mod clean;
mod polygon;

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};

use super::mtl::MtlLibrary;
use super::notes::Notes;
use super::source::read_text;
use super::{Mesh, SceneError};
use crate::material::Material;
use clean::CleanLines;
use polygon::{cut_concave, fan};

/// Triangles and materials of an OBJ file.
#[derive(Debug)]
pub(super) struct ObjFile {
    /// All triangles.
    pub(super) mesh: Mesh,
    /// What `mesh` indexes.
    pub(super) materials: Vec<Material>,
}

const OPTIONS: tobj::LoadOptions =
    tobj::LoadOptions { single_index: true, triangulate: false, ignore_points: true, ignore_lines: true };

/// Reads an OBJ file and the materials it names. What is missing but not vital goes to `notes`.
///
/// # Errors
/// When the file cannot be read, has no face, or a line is malformed or points to a vertex that does not exist.
pub(super) fn read_obj(path: &Path, notes: &mut Notes) -> Result<ObjFile, SceneError> {
    let text = read_text(path)?;
    if text.trim().is_empty() {
        return Err(SceneError::EmptyFile { path: path.into() });
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let library = RefCell::new(MtlLibrary::new(folder.into()));
    let mut lines = CleanLines::new(&text, path);
    let read = tobj::load_obj_buf(&mut lines, &OPTIONS, |name| Ok(load_library(&library, name)));
    lines.finish(read.as_ref().err())?;
    let models = read.map_or(vec![], |(models, _)| models);
    let vertices = lines.vertices();
    let mut library = library.into_inner();
    lines.note(&library, notes);
    let mut mesh = Mesh::default();
    let mut unnamed = None;
    for model in models {
        let mut without = || *unnamed.get_or_insert_with(|| library.default_material());
        let material = model.mesh.material_id.unwrap_or_else(&mut without);
        mesh.append(mesh_of(model.mesh, material));
    }
    if mesh.triangles.is_empty() {
        return Err(SceneError::NoFaces { path: path.into(), vertices });
    }
    let materials = library.into_materials(&mesh.materials, notes)?;
    Ok(ObjFile { mesh, materials })
}

/// What tobj needs to know of the libraries one `mtllib` line names: a stand-in and an index for each material.
fn load_library(library: &RefCell<MtlLibrary>, names: &Path) -> (Vec<tobj::Material>, HashMap<String, usize>) {
    let added = library.borrow_mut().add(&names.to_string_lossy());
    let indices = added.iter().enumerate().map(|(i, name)| (name.clone(), i)).collect();
    (vec![tobj::Material::default(); added.len()], indices)
}

fn mesh_of(mesh: tobj::Mesh, material: usize) -> Mesh {
    let points = |flat: &[f32]| flat.chunks_exact(3).map(Vec3::from_slice).collect::<Vec<_>>();
    let positions = points(&mesh.positions);
    let triangles = triangles_of(&positions, &mesh.indices, &mesh.face_arities);
    Mesh {
        positions,
        normals: points(&mesh.normals).into_iter().map(Vec3::normalize_or_zero).collect(),
        uvs: mesh.texcoords.chunks_exact(2).map(Vec2::from_slice).collect(),
        materials: vec![material as u32; triangles.len()],
        triangles,
    }
}

/// Triangles of faces that have `arities` corners each; of triangles alone when there are no arities.
fn triangles_of(positions: &[Vec3], indices: &[u32], arities: &[u32]) -> Vec<[u32; 3]> {
    if arities.is_empty() {
        return indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    }
    let mut triangles = Vec::with_capacity(indices.len());
    let (mut rest, mut corners) = (indices, vec![]);
    for &arity in arities {
        let (face, after) = rest.split_at(arity as usize);
        rest = after;
        corners.clear();
        corners.extend(face.iter().map(|&v| positions[v as usize]));
        let of_face = |t: [usize; 3]| t.map(|corner| face[corner]);
        match cut_concave(&corners) {
            None => triangles.extend(fan(face.len()).map(of_face)),
            Some(cut) => triangles.extend(cut.into_iter().map(of_face)),
        }
    }
    triangles
}

/// The path of `name`, as a file in `folder` calls another: backslashes are taken for slashes, and when there is no such
/// file, one that differs in case only will do. `None` when there is none either.
pub(super) fn find_file(folder: &Path, name: &str) -> Option<PathBuf> {
    let mended = name.trim().replace('\\', "/");
    let direct = folder.join(&mended);
    if direct.is_file() {
        return Some(direct);
    }
    let mut found = folder.to_path_buf();
    for part in mended.split('/').filter(|part| !part.is_empty() && *part != ".") {
        found = if part == ".." { found.join(part) } else { find_ignoring_case(&found, part)? };
    }
    found.is_file().then_some(found)
}

fn find_ignoring_case(folder: &Path, name: &str) -> Option<PathBuf> {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let exact = folder.join(name);
    if exact.exists() {
        return Some(exact);
    }
    let wanted = name.to_lowercase();
    let entries = std::fs::read_dir(here).ok()?.flatten();
    let mut same: Vec<_> =
        entries.map(|e| e.file_name()).filter(|n| n.to_string_lossy().to_lowercase() == wanted).collect();
    // Folders are listed in no particular order.
    same.sort();
    same.first().map(|n| folder.join(n))
}

#[cfg(test)]
mod tests;
