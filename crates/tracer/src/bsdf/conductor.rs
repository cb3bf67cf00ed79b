//! Rough metal: single scattering from GGX microfacets, visible normals, Schlick's Fresnel.
//!
//! In Mitsuba: `principled` with `metallic = 1`, `base_color` = the reflectance at normal incidence and `roughness` = √α,
//! inside `twosided`; its masking is separable where ours is height-correlated, at most 2 % apart near the horizon.
//! `roughconductor` with `distribution = ggx` has exact Fresnel besides.

use glam::{Vec2, Vec3};

use super::ggx::Ggx;
use super::{Scattered, fresnel};

/// Rough metallic reflection.
#[derive(Clone, Copy, Debug)]
pub struct Conductor {
    reflectance: Vec3,
    ggx: Ggx,
}

impl Conductor {
    /// A metal that reflects `reflectance` at normal incidence, of GGX roughness `alpha` > 0.
    pub const fn new(reflectance: Vec3, alpha: f32) -> Self {
        Self { reflectance, ggx: Ggx::new(alpha) }
    }

    #[inline]
    pub(super) fn sample_direction(&self, outgoing: Vec3, u: Vec2) -> Option<Scattered> {
        let sample = self.ggx.sample_reflection(outgoing, u)?;
        Some(Scattered {
            incoming: sample.incoming,
            weight: sample.weight * fresnel::schlick(self.reflectance, sample.facet_cosine),
            pdf: Some(self.ggx.reflection_pdf(outgoing, sample.incoming)),
            eta: 1.0,
        })
    }

    #[inline]
    pub(super) fn direction_pdf(&self, outgoing: Vec3, incoming: Vec3) -> f32 {
        self.ggx.reflection_pdf(outgoing, incoming)
    }

    #[inline]
    pub(super) fn evaluate(&self, outgoing: Vec3, incoming: Vec3) -> Vec3 {
        let (value, facet_cosine) = self.ggx.evaluate(outgoing, incoming);
        value * fresnel::schlick(self.reflectance, facet_cosine)
    }
}
