//! A mesh where rays meet with it.

use std::borrow::Cow;

use glam::{DVec3, Vec3};

use super::mesh::{IndexedMesh, cross};
use super::moving_placement::MovingPlacement;
use super::{Bounds, Placement};

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
