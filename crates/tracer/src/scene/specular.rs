//! Surfaces that mirror or refract.

use glam::Vec3;

use super::Scene;
use super::placed::Placed;
use crate::bsdf::may_be_specular;

impl Scene {
    /// Whether nothing in it moves.
    pub(crate) fn is_still(&self) -> bool {
        self.placed.iter().all(|placed| placed.moving.is_none())
    }

    /// Corners of all triangles that are perfect mirrors or clear glass, at least in places.
    pub(crate) fn specular_triangles(&self) -> Vec<[Vec3; 3]> {
        let is_specular: Vec<bool> = self.materials.iter().map(may_be_specular).collect();
        let of = |placed: &'_ Placed| {
            let mesh = &self.meshes[placed.mesh];
            let specular = |t: &u32| is_specular[mesh.mesh.materials[*t as usize] as usize];
            let triangles = (0..mesh.mesh.triangles.len() as u32).filter(specular);
            triangles.map(|t| Placed::corners(mesh, t, placed.placement.as_ref())).collect::<Vec<_>>()
        };
        self.placed.iter().flat_map(of).collect()
    }
}
