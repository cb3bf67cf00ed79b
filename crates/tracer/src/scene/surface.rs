//! What a hit triangle looks like at the hit.

use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};

use super::mesh::Mesh;
use super::placed::Placed;
use super::{Placement, Scene};
use super::{cut_out, relief};
use crate::Ray;
use crate::bvh::TriangleHit;
use crate::interaction::Interaction;
use crate::texture::{TexCoords, Texture};

/// γ₇ of pbrt-v4, section 6.8.5: relative error of a barycentric sum.
const GAMMA_7: f32 = 3.5 * f32::EPSILON / (1.0 - 3.5 * f32::EPSILON);

impl Scene {
    /// The surface at a hit on `placed`.
    pub(super) fn interaction(&self, ray: &Ray, placed: usize, hit: &TriangleHit) -> Interaction<'_> {
        let number = placed;
        let placed = &self.placed[placed];
        let indexed = &self.meshes[placed.mesh];
        let mesh = &indexed.mesh;
        let placement = placed.at(ray.time);
        let placement = placement.as_deref();
        let corners = Placed::corners(indexed, hit.triangle, placement);
        let weighted: [Vec3; 3] = std::array::from_fn(|i| hit.barycentric[i] * corners[i]);
        let geometric_normal = placed.cross(corners).normalize().as_vec3();
        let material = &self.materials[mesh.materials[hit.triangle as usize] as usize];
        let smooth = shading_normal(mesh, placement, hit, geometric_normal);
        let uv = mesh.uv(hit);
        let material = cut_out::as_met(material, uv, ray, number, hit.triangle);
        let bent = |map: &Option<Arc<Texture>>| match map {
            Some(map) => {
                let uvs = mesh.corner_uvs(hit.triangle).map(|uvs| uvs.0[usize::from(map.set)]);
                relief::normal(map.lookup(uv), smooth, geometric_normal, corners, uvs)
            }
            None => smooth,
        };
        let shading_normal = bent(&material.maps.normals);
        let coat_normal = material.maps.clear_coat.as_ref().map_or(shading_normal, |coat| bent(&coat.normals));
        Interaction {
            position: weighted[0] + weighted[1] + weighted[2],
            position_error: GAMMA_7 * (weighted[0].abs() + weighted[1].abs() + weighted[2].abs()),
            geometric_normal,
            shading_normal,
            coat_normal,
            uv,
            tint: if mesh.colours.is_empty() { Vec3::ONE } else { mesh.colour(hit).truncate() },
            outgoing: -ray.direction,
            distance: hit.distance,
            time: ray.time,
            emitter: placed.emitters.get(hit.triangle as usize).copied().filter(|&e| e != u32::MAX),
            material,
        }
    }
}

/// Sum of what the triangle's vertices have, by barycentric weight.
fn interpolate<T>(of_vertices: &[T], mesh: &Mesh, hit: &TriangleHit) -> T
where
    T: Copy + std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    let [a, b, c] = mesh.triangles[hit.triangle as usize].map(|v| of_vertices[v as usize]);
    let [u, v, w] = hit.barycentric;
    a * u + b * v + c * w
}

/// Interpolated normal on the side of the geometric one; the geometric one where vertices have none.
fn shading_normal(mesh: &Mesh, placement: Option<&Placement>, hit: &TriangleHit, geometric: Vec3) -> Vec3 {
    if mesh.normals.is_empty() {
        return geometric;
    }
    let own = interpolate(&mesh.normals, mesh, hit);
    let there = placement.map_or(own, |placement| placement.normal(own));
    match there.try_normalize() {
        Some(normal) if normal.dot(geometric) > 0.0 => normal,
        Some(normal) if normal.dot(geometric) < 0.0 => -normal,
        _ => geometric,
    }
}

impl Mesh {
    /// Texture coordinates at a hit; zero where the mesh has none.
    #[inline]
    pub(super) fn uv(&self, hit: &TriangleHit) -> TexCoords {
        let of = |uvs: &[Vec2]| interpolate(uvs, self, hit);
        let first = if self.uvs.is_empty() { Vec2::ZERO } else { of(&self.uvs) };
        TexCoords([first, if self.further_uvs.is_empty() { first } else { of(&self.further_uvs) }])
    }

    /// Colour and opacity of the vertices at a hit; white where the mesh has none.
    #[inline]
    pub(super) fn colour(&self, hit: &TriangleHit) -> Vec4 {
        if self.colours.is_empty() { Vec4::ONE } else { interpolate(&self.colours, self, hit) }
    }
}
