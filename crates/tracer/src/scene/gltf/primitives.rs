//! Meshes of a glTF file.

use std::path::Path;

use glam::{Vec2, Vec3};
use gltf::Semantic;
use gltf::mesh::{Mode, Primitive};

use super::super::Mesh;
use super::super::notes::Notes;
use super::buffers::Buffers;
use super::numbers::{indices, vectors};

/// The meshes of `document`, each with all its primitives. `sets` says which texture coordinates each material is laid out
/// by; the last material is that of primitives that have none.
///
/// # Errors
/// In words, when numbers are not there or corners are vertices that are not.
pub(super) fn read_meshes(
    document: &gltf::Document,
    buffers: &Buffers,
    sets: &[u32],
    path: &Path,
    notes: &mut Notes,
) -> Result<Vec<Mesh>, String> {
    let mut skipped = 0;
    let mut meshes = Vec::with_capacity(document.meshes().len());
    for mesh in document.meshes() {
        let mut whole = Mesh::default();
        for primitive in mesh.primitives() {
            let place =
                |reason: String| format!("meshes[{}].primitives[{}]: {reason}", mesh.index(), primitive.index());
            match read_primitive(&primitive, buffers, sets).map_err(place)? {
                Some(part) => whole.append(part),
                None => skipped += 1,
            }
        }
        meshes.push(whole);
    }
    if skipped > 0 {
        notes.add(format!("{}: {skipped} primitives of points, lines or without positions left out", path.display()));
    }
    if document.meshes().flat_map(|mesh| mesh.primitives()).any(|p| p.get(&Semantic::Colors(0)).is_some()) {
        notes.add(format!("{}: colours of vertices are ignored", path.display()));
    }
    Ok(meshes)
}

/// The triangles of a primitive; `None` when it has none to see.
fn read_primitive(primitive: &Primitive, buffers: &Buffers, sets: &[u32]) -> Result<Option<Mesh>, String> {
    if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(None);
    }
    let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(None) };
    let positions: Vec<Vec3> = vectors::<3>(&positions, buffers)?.into_iter().map(Vec3::from).collect();
    let material = primitive.material().index().unwrap_or(sets.len() - 1);
    let as_many = |what: &str, count: usize| match count == positions.len() {
        true => Ok(()),
        false => Err(format!("{count} {what}s for {} positions", positions.len())),
    };
    let normals: Vec<Vec3> = match primitive.get(&Semantic::Normals) {
        Some(normals) => {
            vectors::<3>(&normals, buffers)?.into_iter().map(|n| Vec3::from(n).normalize_or_zero()).collect()
        }
        None => Vec::new(),
    };
    if !normals.is_empty() {
        as_many("normal", normals.len())?;
    }
    let uvs: Vec<Vec2> = match primitive.get(&Semantic::TexCoords(sets[material])) {
        // From the top left corner of the image to the bottom left one.
        Some(uvs) => vectors::<2>(&uvs, buffers)?.into_iter().map(|[u, v]| Vec2::new(u, 1.0 - v)).collect(),
        None => Vec::new(),
    };
    if !uvs.is_empty() {
        as_many("texture coordinate", uvs.len())?;
    }
    let corners = match primitive.indices() {
        Some(accessor) => indices(&accessor, buffers)?,
        None => (0..positions.len() as u32).collect(),
    };
    if let Some(corner) = corners.iter().find(|corner| **corner as usize >= positions.len()) {
        return Err(format!("a corner is vertex {corner}, of {}", positions.len()));
    }
    let triangles = triangles(&corners, primitive.mode());
    let materials = vec![material as u32; triangles.len()];
    Ok(Some(Mesh { positions, normals, uvs, triangles, materials }))
}

/// Triangles in a list of corners.
fn triangles(corners: &[u32], mode: Mode) -> Vec<[u32; 3]> {
    match mode {
        // Every other one is wound the other way.
        Mode::TriangleStrip => {
            let wound = |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            corners.windows(3).enumerate().map(wound).collect()
        }
        Mode::TriangleFan => match corners {
            [hub, rim @ ..] => rim.windows(2).map(|edge| [*hub, edge[0], edge[1]]).collect(),
            [] => Vec::new(),
        },
        _ => corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_outside() {
        let corners = [0, 1, 2, 3, 4];
        assert_eq!(triangles(&corners, Mode::Triangles), [[0, 1, 2]]);
        assert_eq!(triangles(&corners, Mode::TriangleStrip), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
        assert_eq!(triangles(&corners, Mode::TriangleFan), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert!(
            triangles(&corners[..2], Mode::TriangleStrip).is_empty() && triangles(&[], Mode::TriangleFan).is_empty()
        );
    }
}
