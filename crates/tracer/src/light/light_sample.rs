//! What is found when light is looked for.

use glam::Vec3;

use crate::Ray;

/// Light that may arrive at a point.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction it comes from.
    pub direction: Vec3,
    /// Its radiance, if nothing is in the way; of a delta light the irradiance of a surface across `direction`.
    pub radiance: Vec3,
    /// Density of `direction` per solid angle, the choice of the light included; above 0. Of a delta light the probability
    /// of the choice alone.
    pub pdf: f32,
    /// Whether no ray that follows surfaces can find this light, so that samples like this one have to carry all of it.
    pub is_delta: bool,
    /// What must not be occluded.
    pub shadow_ray: Ray,
}
