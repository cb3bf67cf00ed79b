//! Triangles with what their corners know.

use glam::{DVec3, Vec2, Vec3, Vec4};

use super::{Dropped, Placement};
use crate::bvh::TriangleBvh;
use crate::material::Material;
use crate::texture::TexCoords;

/// Triangles over shared vertices.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Where the vertices are.
    pub positions: Vec<Vec3>,
    /// A normal per vertex, of any length; zero where a vertex has none. Empty when no vertex has one.
    pub normals: Vec<Vec3>,
    /// Texture coordinates per vertex. Empty when no vertex has any.
    pub uvs: Vec<Vec2>,
    /// Texture coordinates of a further set. Empty when no material needs one: then it is the same as the first.
    pub further_uvs: Vec<Vec2>,
    /// What colour and opacity of the surface are multiplied with, per vertex, 0 … 1. Empty when that is 1 everywhere.
    pub colours: Vec<Vec4>,
    /// Vertices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Material of each triangle.
    pub materials: Vec<u32>,
}

/// Coordinates beyond this magnitude overflow f32 in differences and sums of products with unit vectors.
const GREATEST_COORDINATE: f32 = f32::MAX / 16.0;

/// Whether the coordinates of `point` are numbers one can compute with.
pub(super) fn is_in_range(point: Vec3) -> bool {
    point.abs().cmple(Vec3::splat(GREATEST_COORDINATE)).all()
}

/// Twice the area times the unit normal of a triangle; in f64 so that no size over- or underflows.
#[inline]
pub(super) fn cross(corners: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = corners.map(|v| v.as_dvec3());
    (b - a).cross(c - a)
}

impl Mesh {
    /// Corners of a triangle.
    #[inline]
    pub(super) fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|v| self.positions[v as usize])
    }

    /// Texture coordinates of a triangle's corners; zero where the mesh has none.
    #[inline]
    pub(super) fn corner_uvs(&self, triangle: u32) -> [TexCoords; 3] {
        self.triangles[triangle as usize].map(|v| {
            let first = if self.uvs.is_empty() { Vec2::ZERO } else { self.uvs[v as usize] };
            TexCoords([first, self.further_uvs.get(v as usize).copied().unwrap_or(first)])
        })
    }

    /// Colours of a triangle's corners; white where the mesh has none.
    #[inline]
    pub(super) fn corner_colours(&self, triangle: u32) -> [Vec4; 3] {
        let corners = self.triangles[triangle as usize];
        corners.map(|v| if self.colours.is_empty() { Vec4::ONE } else { self.colours[v as usize] })
    }

    /// The mesh with its vertices where `placement` puts them. A mirrored mesh is wound the other way round, so that
    /// its outside stays outside.
    pub(super) fn moved(mut self, placement: &Placement) -> Self {
        if *placement == Placement::IDENTITY {
            return self;
        }
        self.positions.iter_mut().for_each(|p| *p = placement.point(*p));
        self.normals.iter_mut().for_each(|n| *n = placement.normal(*n).normalize_or_zero());
        if placement.is_mirrored() {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        self
    }

    /// Adds another mesh's triangles.
    pub(super) fn append(&mut self, mut other: Self) {
        if self.positions.is_empty() {
            *self = other;
            return;
        }
        let first = self.positions.len() as u32;
        if !(self.normals.is_empty() && other.normals.is_empty()) {
            self.normals.resize(self.positions.len(), Vec3::ZERO);
            other.normals.resize(other.positions.len(), Vec3::ZERO);
        }
        if !(self.uvs.is_empty() && other.uvs.is_empty()) {
            self.uvs.resize(self.positions.len(), Vec2::ZERO);
            other.uvs.resize(other.positions.len(), Vec2::ZERO);
        }
        if !(self.further_uvs.is_empty() && other.further_uvs.is_empty()) {
            for mesh in [&mut *self, &mut other] {
                let own = if mesh.uvs.is_empty() { vec![Vec2::ZERO; mesh.positions.len()] } else { mesh.uvs.clone() };
                if mesh.further_uvs.is_empty() {
                    mesh.further_uvs = own;
                }
            }
        }
        if !(self.colours.is_empty() && other.colours.is_empty()) {
            self.colours.resize(self.positions.len(), Vec4::ONE);
            other.colours.resize(other.positions.len(), Vec4::ONE);
        }
        self.positions.append(&mut other.positions);
        self.normals.append(&mut other.normals);
        self.uvs.append(&mut other.uvs);
        self.further_uvs.append(&mut other.further_uvs);
        self.colours.append(&mut other.colours);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
        self.materials.append(&mut other.materials);
    }

    /// Drops triangles no ray can hit.
    fn clean(&mut self, dropped: &mut Dropped) {
        let verdict = |t: u32| {
            let corners = self.corners(t);
            if !corners.into_iter().all(is_in_range) {
                dropped.not_finite += 1;
                return false;
            }
            let sound = cross(corners).length_squared() > 0.0;
            dropped.degenerate += usize::from(!sound);
            sound
        };
        let keep: Vec<bool> = (0..self.triangles.len() as u32).map(verdict).collect();
        let mut kept = keep.iter();
        self.triangles.retain(|_| kept.next() == Some(&true));
        let mut kept = keep.iter();
        self.materials.retain(|_| kept.next() == Some(&true));
    }
}

/// A mesh with a tree over its triangles.
#[derive(Debug)]
pub(super) struct IndexedMesh {
    pub(super) mesh: Mesh,
    /// `None` when there are no triangles.
    pub(super) tree: Option<TriangleBvh>,
    /// Whether rays may pass through some of its triangles.
    pub(super) is_cut_out: bool,
}

impl IndexedMesh {
    /// Drops and counts useless triangles, then builds the tree.
    pub(super) fn build(mut mesh: Mesh, materials: &[Material], dropped: &mut Dropped) -> Self {
        mesh.clean(dropped);
        let tree = TriangleBvh::build(mesh.triangles.len() as u32, |t| mesh.corners(t));
        let is_cut_out = mesh.materials.iter().any(|&m| materials[m as usize].maps.opacity.is_some());
        Self { mesh, tree, is_cut_out }
    }

    /// Positions that triangles use.
    pub(super) fn used_positions(&self) -> impl Iterator<Item = &Vec3> + Clone {
        self.mesh.triangles.iter().flatten().map(|&v| &self.mesh.positions[v as usize])
    }
}
