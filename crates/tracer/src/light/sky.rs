//! A sky of the same radiance everywhere, infinitely far away.

use glam::{Vec2, Vec3};

use super::LightSample;
use crate::bsdf::Frame;
use crate::interaction::Interaction;
use crate::sampler::warp::{cosine_hemisphere_pdf, sample_cosine_hemisphere};

/// The sky, seen from surfaces that reflect: directions in proportion to the cosine with the surface's normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sky {
    pub(super) radiance: Vec3,
}

impl Sky {
    pub(super) fn sample(&self, from: &Interaction, normal: Vec3, u: Vec2) -> Option<LightSample> {
        let local = sample_cosine_hemisphere(u);
        let direction = Frame::new(normal).to_world(local);
        let pdf = self.pdf(normal, direction);
        let shadow_ray = from.spawn(direction);
        (pdf > 0.0).then_some(LightSample { direction, radiance: self.radiance, pdf, shadow_ray })
    }

    pub(super) fn pdf(&self, normal: Vec3, direction: Vec3) -> f32 {
        cosine_hemisphere_pdf(normal.dot(direction))
    }
}
