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
    #[inline]
    pub(super) fn sample_direction(&self, u: Vec2) -> Scattered {
        let incoming = sample_cosine_hemisphere(u);
        Scattered { incoming, weight: self.reflectance, pdf: Some(cosine_hemisphere_pdf(incoming.z)), eta: 1.0 }
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
