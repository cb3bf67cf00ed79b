//! Meshes of a glTF file.

use std::path::Path;

use glam::{Vec2, Vec3, Vec4};
use gltf::Accessor;
use gltf::Semantic;
use gltf::accessor::Dimensions;
use gltf::material::AlphaMode;
use gltf::mesh::{Mode, Primitive};

use super::super::Mesh;
use super::super::notes::Notes;
use super::buffers::Buffers;
use super::materials::Needs;
use super::numbers::{as_many, indices, shares, vectors};
use super::pose::Pose;

/// The meshes of `document`, each with all its primitives. `needs` tells what each material has to be told; the last two are
/// for primitives that have none, without colours of vertices and with.
///
/// # Errors
/// In words, when numbers are not there or corners are vertices that are not.
pub(super) fn read_meshes(
    document: &gltf::Document,
    buffers: &Buffers,
    needs: &[Needs],
    path: &Path,
    notes: &mut Notes,
) -> Result<Vec<Mesh>, String> {
    let primitives = || document.meshes().flat_map(|mesh| mesh.primitives());
    let skipped = primitives().filter(|primitive| !is_seen(primitive)).count();
    if skipped > 0 {
        notes.add(format!("{}: {skipped} primitives of points, lines or without positions left out", path.display()));
    }
    let as_it_is = |mesh: gltf::Mesh| {
        read_mesh(&mesh, buffers, needs, &Pose { weights: mesh.weights().unwrap_or_default().to_vec(), joints: None })
    };
    document.meshes().map(as_it_is).collect()
}

/// A mesh in the pose `pose`.
///
/// # Errors
/// As [`read_meshes`].
pub(super) fn read_mesh(mesh: &gltf::Mesh, buffers: &Buffers, needs: &[Needs], pose: &Pose) -> Result<Mesh, String> {
    let mut whole = Mesh::default();
    for primitive in mesh.primitives().filter(is_seen) {
        let place = |reason: String| format!("meshes[{}].primitives[{}]: {reason}", mesh.index(), primitive.index());
        whole.append(read_primitive(&primitive, buffers, needs, pose).map_err(place)?);
    }
    Ok(whole)
}

/// Whether there is anything to see of a primitive.
fn is_seen(primitive: &Primitive) -> bool {
    let has_faces = matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan);
    has_faces && primitive.get(&Semantic::Positions).is_some()
}

/// The triangles of a primitive; none where it has no positions.
fn read_primitive(primitive: &Primitive, buffers: &Buffers, needs: &[Needs], pose: &Pose) -> Result<Mesh, String> {
    let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(Mesh::default()) };
    let mut positions: Vec<Vec3> = vectors::<3>(&positions, buffers)?.into_iter().map(Vec3::from).collect();
    let colours = match primitive.get(&Semantic::Colors(0)) {
        Some(colours) => read_colours(&colours, buffers)?,
        None => Vec::new(),
    };
    let default = needs.len() - if colours.is_empty() { 2 } else { 1 };
    let material = primitive.material().index().unwrap_or(default);
    let vertices = positions.len();
    let mut normals: Vec<Vec3> = match primitive.get(&Semantic::Normals) {
        Some(normals) => {
            vectors::<3>(&normals, buffers)?.into_iter().map(|n| Vec3::from(n).normalize_or_zero()).collect()
        }
        None => Vec::new(),
    };
    if !normals.is_empty() {
        as_many("normal", normals.len(), vertices)?;
    }
    pose.take(primitive, buffers, &mut positions, &mut normals)?;
    let [set, further] = needs[material].sets;
    let uvs = read_uvs(primitive, set, buffers)?;
    let further_uvs = if further == set { Vec::new() } else { read_uvs(primitive, further, buffers)? };
    for uvs in [&uvs, &further_uvs].into_iter().filter(|uvs| !uvs.is_empty()) {
        as_many("texture coordinate", uvs.len(), vertices)?;
    }
    if !colours.is_empty() {
        as_many("vertex colour", colours.len(), vertices)?;
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
    let mut mesh = Mesh { positions, normals, uvs, further_uvs, colours, triangles, materials };
    if needs[material].alpha == AlphaMode::Opaque {
        // Nobody asks for it.
        mesh.colours.iter_mut().for_each(|colour| colour.w = 1.0);
    }
    Ok(mesh)
}

/// Texture coordinates, from the bottom left corner of an image on where a file has them from the top left one; none where the
/// primitive has none of that set.
fn read_uvs(primitive: &Primitive, set: u32, buffers: &Buffers) -> Result<Vec<Vec2>, String> {
    let Some(uvs) = primitive.get(&Semantic::TexCoords(set)) else { return Ok(Vec::new()) };
    Ok(vectors::<2>(&uvs, buffers)?.into_iter().map(|[u, v]| Vec2::new(u, 1.0 - v)).collect())
}

/// Linear colours, with opacity or without; what is no share of light is taken for the nearest that is.
fn read_colours(accessor: &Accessor, buffers: &Buffers) -> Result<Vec<Vec4>, String> {
    let colours: Vec<Vec4> = match accessor.dimensions() {
        Dimensions::Vec3 => shares::<3>(accessor, buffers)?.into_iter().map(|c| Vec3::from(c).extend(1.0)).collect(),
        _ => shares::<4>(accessor, buffers)?.into_iter().map(Vec4::from).collect(),
    };
    let sound = |c: f32| if c.is_nan() { 1.0 } else { c.clamp(0.0, 1.0) };
    Ok(colours.into_iter().map(|colour| Vec4::from(colour.to_array().map(sound))).collect())
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
