//! Meshes standing in the scene.

use glam::Vec3;

use super::emitters::{EmissiveTriangle, emitters_of, ranks};
use super::mesh::{IndexedMesh, Mesh, is_in_range};
use super::moving_placement::MovingPlacement;
use super::placed::Placed;
use super::{Bounds, Dropped, Motion, Placement, SceneError};
use crate::bvh::WideBvh;
use crate::material::Material;

/// A mesh standing in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Index of the mesh.
    pub mesh: usize,
    /// Where it stands; at time 0, when it moves.
    pub placement: Placement,
    /// How it moves.
    pub motion: Option<Motion>,
}

/// Checks that every index points to something.
pub(super) fn check(meshes: &[Mesh], instances: &[Instance], materials: usize) -> Result<(), SceneError> {
    let bad = |what, index: usize, count| Err(SceneError::BadIndex { what, index, count });
    if let Some(i) = instances.iter().find(|i| i.mesh >= meshes.len()) {
        return bad("mesh", i.mesh, meshes.len());
    }
    for mesh in meshes {
        let vertices = mesh.positions.len();
        if let Some(&v) = mesh.triangles.iter().flatten().find(|&&v| v as usize >= vertices) {
            return bad("vertex", v as usize, vertices);
        }
        if let Some(&m) = mesh.materials.iter().find(|&&m| m as usize >= materials) {
            return bad("material", m as usize, materials);
        }
        if mesh.materials.len() != mesh.triangles.len() {
            return bad("material of triangle", mesh.materials.len(), mesh.triangles.len());
        }
        let of_vertices = [
            ("normal", mesh.normals.len()),
            ("texture coordinate", mesh.uvs.len()),
            ("further texture coordinate", mesh.further_uvs.len()),
            ("vertex colour", mesh.colours.len()),
        ];
        for (what, count) in of_vertices {
            if count != 0 && count != vertices {
                return bad(what, count, vertices);
            }
        }
    }
    Ok(())
}

/// A mesh and where it stands, nowhere in particular when it is in scene space already; and how it moves.
pub(super) type Stand = (usize, Option<Placement>, Option<Motion>);

/// Merges all meshes that stand in the scene once and do not move into the first mesh returned.
pub(super) fn merge_single(mut meshes: Vec<Mesh>, instances: &[Instance]) -> (Vec<Mesh>, Vec<Stand>) {
    let mut uses = vec![0; meshes.len()];
    instances.iter().for_each(|instance| uses[instance.mesh] += 1);
    let mut merged = Mesh::default();
    let is_merged = |i: &&Instance| uses[i.mesh] == 1 && i.motion.is_none();
    for instance in instances.iter().filter(is_merged) {
        merged.append(std::mem::take(&mut meshes[instance.mesh]).moved(&instance.placement));
    }
    let others = instances.iter().filter(|i| !is_merged(i));
    let mut stands = vec![(0, None, None)];
    stands.extend(others.map(|i| (i.mesh + 1, Some(i.placement), i.motion)));
    meshes.insert(0, merged);
    (meshes, stands)
}

/// Prepares meshes where they stand, and lists all emitters. Those that are empty are left out, and so are those that reach
/// too far to compute with, whose triangles are counted as dropped.
pub(super) fn place(
    meshes: &[IndexedMesh],
    stands: &[Stand],
    materials: &[Material],
    dropped: &mut Dropped,
) -> (Vec<Placed>, Vec<EmissiveTriangle>) {
    let (mut all, mut emitters) = (vec![], vec![]);
    for &(index, placement, motion) in stands {
        let mesh = &meshes[index];
        if mesh.tree.is_none() {
            continue;
        }
        let at = |p: &Vec3| placement.as_ref().map_or(*p, |placement| placement.point(*p));
        let moving = placement.zip(motion).map(|(start, motion)| MovingPlacement::new(start, motion));
        let still = || Bounds::of(mesh.used_positions().map(at));
        let bounds = moving.map_or_else(still, |moving| moving.sweep(mesh.used_positions()));
        if !(is_in_range(bounds.min) && is_in_range(bounds.max)) {
            dropped.not_finite += mesh.mesh.triangles.len();
            continue;
        }
        let first = emitters.len() as u32;
        let shift = |rank: u32| if rank == u32::MAX { rank } else { first + rank };
        let ranks = ranks(mesh, materials).into_iter().map(shift).collect();
        let placed = Placed { mesh: index, placement, moving, bounds, emitters: ranks };
        emitters.extend(emitters_of(mesh, &placed, all.len() as u32, materials));
        all.push(placed);
    }
    (all, emitters)
}

/// A tree over meshes where they stand.
#[derive(Debug)]
pub(super) struct InstanceTree {
    pub(super) boxes: WideBvh,
    /// Which of the placed meshes each leaf holds.
    pub(super) leaves: Vec<usize>,
}

impl InstanceTree {
    /// Builds the tree, when there is more than one to choose from.
    pub(super) fn build(placed: &[Placed]) -> Option<Self> {
        let boxes: Vec<Bounds> = placed.iter().map(|p| p.bounds).collect();
        let (boxes, leaves) = if boxes.len() > 1 { WideBvh::build(&boxes, 1)? } else { return None };
        Some(Self { boxes, leaves: leaves.iter().map(|members| members[0] as usize).collect() })
    }
}
