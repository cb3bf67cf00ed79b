//! Rough metal: GGX microfacets, visible normals, Schlick's Fresnel.
//!
//! Light that facets reflect more than once is missing from that model. It is given back in proportion to what is there
//! (Turquin 2019, *Practical Multiple Scattering Compensation for Microfacet Models*): with the albedo E of perfectly
//! reflecting facets towards the viewer,
//!
//! f = f_single · (1 + F₀ (1 − E(o)) / E(o)).
//!
//! A perfect reflector reflects everything; sampling needs no second lobe (that of Kulla and Conty 2017 puts what smooth
//! metal loses into directions near the horizon, where no sampling by the cosine finds it). The price is reciprocity, which
//! is lost where E depends on the direction, so for rough surfaces near the horizon.
//!
//! In Mitsuba: `principled` with `metallic = 1`, `base_color` = the reflectance at normal incidence and `roughness` = √α,
//! inside `twosided`, has the first factor; its masking is separable where ours is height-correlated, at most 2 % apart
//! near the horizon. `roughconductor` with `distribution = ggx` has exact Fresnel besides.

use glam::{Vec2, Vec3};

use super::ggx::Ggx;
use super::{Scattered, fresnel};

/// Rough metallic reflection, seen from one direction.
#[derive(Clone, Copy, Debug)]
pub struct Conductor {
    reflectance: Vec3,
    ggx: Ggx,
    /// All that is reflected ÷ what is reflected once.
    compensation: Vec3,
}

impl Conductor {
    /// A metal that reflects `reflectance` at normal incidence, of GGX roughness `alpha` > 0, of which perfectly reflecting
    /// facets would reflect the share `albedo` towards the viewer in a single event.
    pub fn new(reflectance: Vec3, alpha: f32, albedo: f32) -> Self {
        let compensation = Vec3::ONE + reflectance * ((1.0 - albedo) / albedo);
        Self { reflectance, ggx: Ggx::new(alpha), compensation }
    }

    #[inline]
    pub(super) fn sample_direction(&self, outgoing: Vec3, u: Vec2) -> Option<Scattered> {
        let sample = self.ggx.sample_reflection(outgoing, u)?;
        Some(Scattered {
            incoming: sample.incoming,
            weight: sample.weight * self.compensation * fresnel::schlick(self.reflectance, sample.facet_cosine),
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
        value * self.compensation * fresnel::schlick(self.reflectance, facet_cosine)
    }
}
