//! Meshes standing in the scene.

use std::borrow::Cow;

use glam::{DVec3, Vec3};

use super::emitters::{EmissiveTriangle, emitters_of, ranks};
use super::mesh::{IndexedMesh, Mesh, is_in_range};
use super::motion::MovingPlacement;
use super::{Bounds, Dropped, Motion, Placement};
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

/// A mesh standing in the scene, ready for rays.
#[derive(Debug)]
pub(super) struct Placed {
    pub(super) mesh: usize,
    /// `None` when the mesh is in scene space already. When it moves, its place at time 0.
    pub(super) placement: Option<Placement>,
    pub(super) moving: Option<MovingPlacement>,
    /// All of it at any time.
    pub(super) bounds: Bounds,
    /// For each triangle its index among the scene's emitters; `u32::MAX` for none. Empty when none emits.
    pub(super) emitters: Vec<u32>,
}

impl Placed {
    /// Where it stands at `time`; `None` when the mesh is in scene space already.
    #[inline]
    pub(super) fn at(&self, time: f32) -> Option<Cow<'_, Placement>> {
        let moved = self.moving.as_ref().map(|moving| Cow::Owned(moving.at(time)));
        moved.or_else(|| self.placement.as_ref().map(Cow::Borrowed))
    }

    /// Corners of a triangle, in scene space, with the mesh standing at `placement`.
    #[inline]
    pub(super) fn corners(mesh: &IndexedMesh, triangle: u32, placement: Option<&Placement>) -> [Vec3; 3] {
        let corners = mesh.mesh.corners(triangle);
        placement.map_or(corners, |placement| corners.map(|c| placement.point(c)))
    }

    /// Twice the area times the unit normal, on the side of the winding in the mesh's own space: a mirrored mesh keeps
    /// its outside outside.
    #[inline]
    pub(super) fn cross(&self, corners: [Vec3; 3]) -> DVec3 {
        let cross = cross(corners);
        if self.placement.is_some_and(|p| p.is_mirrored()) { -cross } else { cross }
    }
}

/// Twice the area times the unit normal of a triangle; in f64 so that no size over- or underflows.
#[inline]
pub(super) fn cross(corners: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = corners.map(|v| v.as_dvec3());
    (b - a).cross(c - a)
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
