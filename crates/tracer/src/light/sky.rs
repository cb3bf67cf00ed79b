//! The sky, seen from surfaces.

use glam::{Vec2, Vec3};

use super::light_sample::LightSample;
use super::receiver::Receiver;
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
    pub(super) fn sample(&self, from: &Interaction, receiver: Receiver, u: Vec2) -> Option<LightSample> {
        let (direction, pdf) = match self.environment.map() {
            Some(_) => self.environment.sample_direction(u).map(|sample| (sample.direction, sample.pdf))?,
            None => {
                let direction = cosine_direction(receiver, u);
                (direction, self.pdf(receiver, direction))
            }
        };
        let radiance = self.environment.radiance(direction);
        (pdf > 0.0).then(|| LightSample {
            direction,
            radiance,
            pdf,
            is_delta: false,
            shadow_ray: from.spawn(direction),
        })
    }

    pub(super) fn pdf(&self, receiver: Receiver, direction: Vec3) -> f32 {
        let cosine = receiver.normal.dot(direction);
        match self.environment.map() {
            Some(_) => self.environment.direction_pdf(direction),
            None if receiver.two_sided => 0.5 * cosine_hemisphere_pdf(cosine.abs()),
            None => cosine_hemisphere_pdf(cosine),
        }
    }
}

/// A direction in proportion to the cosine with the receiver's normal, on either side of it when both matter.
fn cosine_direction(receiver: Receiver, u: Vec2) -> Vec3 {
    if !receiver.two_sided {
        return Frame::new(receiver.normal).to_world(sample_cosine_hemisphere(u));
    }
    let (side, along) = if u.x < 0.5 { (1.0, 2.0 * u.x) } else { (-1.0, 2.0 * u.x - 1.0) };
    Frame::new(side * receiver.normal).to_world(sample_cosine_hemisphere(Vec2::new(along, u.y)))
}
