//! The sky, seen from surfaces.

use glam::{Vec2, Vec3};

use super::LightSample;
use crate::bsdf::Frame;
use crate::environment::Environment;
use crate::interaction::Interaction;
use crate::sampler::warp::{cosine_hemisphere_pdf, sample_cosine_hemisphere};

/// The sky, seen from surfaces that reflect. A map is sampled by its radiance; a constant sky, which has nothing to look
/// for, in proportion to the cosine with the surface's normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sky<'a> {
    pub(super) environment: &'a Environment,
}

impl Sky<'_> {
    pub(super) fn sample(&self, from: &Interaction, normal: Vec3, u: Vec2) -> Option<LightSample> {
        let (direction, pdf) = match self.environment.map() {
            Some(_) => self.environment.sample_direction(u).map(|sample| (sample.direction, sample.pdf))?,
            None => {
                let direction = Frame::new(normal).to_world(sample_cosine_hemisphere(u));
                (direction, self.pdf(normal, direction))
            }
        };
        let radiance = self.environment.radiance(direction);
        (pdf > 0.0).then(|| LightSample { direction, radiance, pdf, shadow_ray: from.spawn(direction) })
    }

    pub(super) fn pdf(&self, normal: Vec3, direction: Vec3) -> f32 {
        match self.environment.map() {
            Some(_) => self.environment.direction_pdf(direction),
            None => cosine_hemisphere_pdf(normal.dot(direction)),
        }
    }
}
