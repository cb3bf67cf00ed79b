//! Perfect mirror. Mitsuba's `conductor` with `material = none` and `specular_reflectance`, inside `twosided`.

use glam::Vec3;

use super::Scattered;

/// Perfect mirror reflection.
#[derive(Clone, Copy, Debug)]
pub struct Mirror {
    /// Share of light reflected, 0 … 1.
    pub reflectance: Vec3,
}

impl Mirror {
    #[inline]
    pub(super) fn sample_direction(&self, outgoing: Vec3) -> Scattered {
        let incoming = Vec3::new(-outgoing.x, -outgoing.y, outgoing.z);
        Scattered { incoming, weight: self.reflectance, pdf: None, eta: 1.0 }
    }
}
