//! The GGX microfacet distribution with height-correlated masking, and its visible normals.
//!
//! Walter et al. 2007, *Microfacet Models for Refraction through Rough Surfaces*; Heitz 2014, *Understanding the
//! Masking-Shadowing Function*; Heitz 2018, *Sampling the GGX Distribution of Visible Normals*. Directions are unit
//! vectors in the local frame with z > 0.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::{Vec2, Vec3};

/// An isotropic GGX surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ggx {
    alpha: f32,
}

/// A microfacet reflection without its Fresnel factor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflection {
    /// Reflected direction.
    pub(super) incoming: Vec3,
    /// Cosine between either direction and the microfacet's normal.
    pub(super) facet_cosine: f32,
    /// f·cos θ ÷ pdf: G₂/G₁ of the microfacets, 0 … 1.
    pub(super) weight: f32,
}

impl Ggx {
    /// A surface of roughness `alpha` > 0.
    pub(super) const fn new(alpha: f32) -> Self {
        Self { alpha }
    }

    /// Density of microfacet normals D(h), per solid angle and projected area.
    ///
    /// Written with the horizontal components, which stay exact when a smooth surface leaves 1 − z² to cancellation.
    #[inline]
    fn density(self, normal: Vec3) -> f32 {
        let alpha2 = self.alpha * self.alpha;
        let sin2 = normal.x * normal.x + normal.y * normal.y;
        let stretched = sin2 / alpha2 + normal.z * normal.z;
        FRAC_1_PI / (alpha2 * stretched * stretched)
    }

    /// cos θ · (1 + 2Λ), Λ being Smith's function: √(cos² + α² sin²).
    #[inline]
    fn smith(self, direction: Vec3) -> f32 {
        let sin2 = direction.x * direction.x + direction.y * direction.y;
        (direction.z * direction.z + self.alpha * self.alpha * sin2).sqrt()
    }

    /// f·cos θᵢ without Fresnel: D G₂ / (4 cos θₒ); and the cosine at the microfacet.
    #[inline]
    pub(super) fn evaluate(self, outgoing: Vec3, incoming: Vec3) -> (f32, f32) {
        let half = (outgoing + incoming).normalize();
        let masking = self.smith(outgoing) * incoming.z + self.smith(incoming) * outgoing.z;
        (self.density(half) * incoming.z / (2.0 * masking), outgoing.dot(half).clamp(0.0, 1.0))
    }

    /// Density per solid angle with which [`sample_reflection`](Self::sample_reflection) returns `incoming`:
    /// G₁(o) D(h) / (4 cos θₒ). It integrates to the share of samples that stay above the surface.
    #[inline]
    pub(super) fn reflection_pdf(self, outgoing: Vec3, incoming: Vec3) -> f32 {
        let half = (outgoing + incoming).normalize();
        self.density(half) / (2.0 * (outgoing.z + self.smith(outgoing)))
    }

    /// Reflects `outgoing` about a visible microfacet. `None` where the reflection goes below the surface.
    #[inline]
    pub(super) fn sample_reflection(self, outgoing: Vec3, u: Vec2) -> Option<Reflection> {
        let normal = self.sample_visible_normal(outgoing, u);
        let facet_cosine = outgoing.dot(normal).clamp(0.0, 1.0);
        let incoming = 2.0 * facet_cosine * normal - outgoing;
        if incoming.z <= 0.0 {
            return None;
        }
        let weight = self.reflection_weight(outgoing, incoming);
        Some(Reflection { incoming: incoming.normalize(), facet_cosine, weight })
    }

    /// G₂/G₁ of both directions, on the same side: f·cos θ ÷ pdf of a reflection.
    #[inline]
    pub(super) fn reflection_weight(self, outgoing: Vec3, incoming: Vec3) -> f32 {
        let (so, si) = (self.smith(outgoing), self.smith(incoming));
        incoming.z * (outgoing.z + so) / (so * incoming.z + si * outgoing.z)
    }

    /// Density of visible normals per solid angle, G₁(o) D(h) (o·h) / cos θₒ.
    #[inline]
    pub(super) fn visible_density(self, outgoing: Vec3, normal: Vec3) -> f32 {
        2.0 * self.density(normal) * outgoing.dot(normal).max(0.0) / (outgoing.z + self.smith(outgoing))
    }

    /// Share of the facets facing `direction` that it reaches, Smith's G₁.
    #[inline]
    pub(super) fn masking(self, direction: Vec3) -> f32 {
        2.0 * direction.z / (direction.z + self.smith(direction))
    }

    /// A microfacet normal in proportion to the area that shows towards `outgoing`.
    #[inline]
    pub(super) fn sample_visible_normal(self, outgoing: Vec3, u: Vec2) -> Vec3 {
        let stretched = Vec3::new(self.alpha * outgoing.x, self.alpha * outgoing.y, outgoing.z).normalize();
        let length2 = stretched.x * stretched.x + stretched.y * stretched.y;
        let tangent = if length2 > 0.0 { Vec3::new(-stretched.y, stretched.x, 0.0) / length2.sqrt() } else { Vec3::X };
        let bitangent = stretched.cross(tangent);
        let (radius, (sin, cos)) = (u.x.sqrt(), (TAU * u.y).sin_cos());
        let (p, q) = (radius * cos, radius * sin);
        let s = 0.5 * (1.0 + stretched.z);
        let q = (1.0 - s) * (1.0 - p * p).max(0.0).sqrt() + s * q;
        let r = (1.0 - p * p - q * q).max(0.0).sqrt();
        let normal = p * tangent + q * bitangent + r * stretched;
        Vec3::new(self.alpha * normal.x, self.alpha * normal.y, normal.z.max(0.0)).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The projected area of all microfacets is the area of the surface: ∫ D cos θ dω = 1.
    #[test]
    fn the_distribution_covers_the_surface() {
        for alpha in [0.05, 0.3, 1.0] {
            let steps = 200_000;
            let sum: f64 = (0..steps)
                .map(|i| {
                    // Uniform in tan θ · (1 + tan²)⁻¹ … would need the answer; uniform in θ needs no thought.
                    let theta = (i as f32 + 0.5) / steps as f32 * std::f32::consts::FRAC_PI_2;
                    let normal = Vec3::new(theta.sin(), 0.0, theta.cos());
                    f64::from(Ggx::new(alpha).density(normal) * theta.cos() * theta.sin())
                })
                .sum();
            let integral = sum / f64::from(steps) * std::f64::consts::FRAC_PI_2 * std::f64::consts::TAU;
            assert!((integral - 1.0).abs() < 1e-3, "{alpha}: {integral}");
        }
    }

    #[test]
    fn a_sample_weighs_what_evaluation_and_density_say() {
        for alpha in [0.001, 0.05, 0.5, 1.0] {
            for cosine in [0.02_f32, 0.5, 1.0] {
                let outgoing = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
                for i in 0..64 {
                    let u = Vec2::new((i % 8) as f32 + 0.5, (i / 8) as f32 + 0.5) / 8.0;
                    let ggx = Ggx::new(alpha);
                    let Some(sample) = ggx.sample_reflection(outgoing, u) else { continue };
                    let (value, _) = ggx.evaluate(outgoing, sample.incoming);
                    let weight = value / ggx.reflection_pdf(outgoing, sample.incoming);
                    assert!((weight - sample.weight).abs() < 2e-3, "{alpha} {cosine} {weight} {}", sample.weight);
                    assert!(sample.weight <= 1.000_001);
                }
            }
        }
    }
}
