//! What is known of one lamp or several without looking at each.

use super::normal_cone::NormalCone;
use crate::bvh::Bounds;

/// Where one lamp or several are, where they shine, and how much.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    /// All of them, at any time.
    pub(super) bounds: Bounds,
    /// All normals they have at any time; they emit into the hemispheres round these.
    pub(super) cone: NormalCone,
    /// At least 0.
    pub(super) power: f64,
}

impl LightBounds {
    /// What holds both.
    pub(super) fn union(self, other: Self) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            cone: self.cone.union(other.cone),
            power: self.power + other.power,
        }
    }

    /// Cost of looking for light in it: power × directions × squared size (Conty Estevez and Kulla 2018, section 4.4). The
    /// size is that of the sphere which importance is computed from, where they have the surface of the box.
    pub(super) fn cost(&self) -> f64 {
        self.power * self.cone.measure() * self.bounds.extent().as_dvec3().length_squared()
    }

    /// Middle of the box along `axis`.
    pub(super) fn middle(&self, axis: usize) -> f64 {
        0.5 * (f64::from(self.bounds.min[axis]) + f64::from(self.bounds.max[axis]))
    }
}
