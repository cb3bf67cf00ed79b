//! Positions among lamps.

use glam::{DVec3, Vec3};

use crate::bvh::Bounds;

/// Takes positions to where the lamps fill a box of size one: no square over- or underflows, however large the scene.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scale {
    origin: DVec3,
    per_unit: f64,
}

impl Scale {
    /// That of lamps within `bounds`.
    pub(super) fn of(bounds: &Bounds) -> Self {
        let diagonal = bounds.extent().as_dvec3().length();
        Self { origin: bounds.centre().as_dvec3(), per_unit: if diagonal > 0.0 { 1.0 / diagonal } else { 1.0 } }
    }

    #[inline]
    pub(super) fn position(&self, p: Vec3) -> Vec3 {
        ((p.as_dvec3() - self.origin) * self.per_unit).as_vec3()
    }
}
