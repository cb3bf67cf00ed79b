//! Lambert's surface: the same radiance into every direction. Mitsuba's `diffuse` inside `twosided`.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};

use super::Scattered;
use crate::sampler::warp::{cosine_hemisphere_pdf, sample_cosine_hemisphere};

/// Lambertian reflection.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse {
    /// Share of light reflected, 0 … 1.
    pub reflectance: Vec3,
}

impl Diffuse {
    /// `None` for a direction in the surface itself, whose density is zero.
    #[inline]
    pub(super) fn sample_direction(&self, u: Vec2) -> Option<Scattered> {
        let incoming = sample_cosine_hemisphere(u);
        let pdf = cosine_hemisphere_pdf(incoming.z);
        (pdf > 0.0).then_some(Scattered { incoming, weight: self.reflectance, pdf: Some(pdf), eta: 1.0 })
    }

    #[inline]
    pub(super) fn direction_pdf(&self, incoming: Vec3) -> f32 {
        cosine_hemisphere_pdf(incoming.z)
    }

    #[inline]
    pub(super) fn evaluate(&self, incoming: Vec3) -> Vec3 {
        self.reflectance * (incoming.z * FRAC_1_PI)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rim_of_the_disc_gives_no_direction_of_density_zero() {
        let diffuse = Diffuse { reflectance: Vec3::ONE };
        assert!(diffuse.sample_direction(Vec2::new(0.0, 0.5)).is_none());
        assert!(diffuse.sample_direction(Vec2::new(0.01, 0.5)).is_some());
    }
}
