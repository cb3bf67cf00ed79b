//! Rough dielectric: reflection and refraction by GGX microfacets (Walter et al. 2007), visible normals, exact Fresnel.
//!
//! Light that facets scatter more than once is missing from that model. It is given back by dividing the whole by its own
//! albedo, reflection and refraction together (Turquin 2019, *Practical Multiple Scattering Compensation for Microfacet
//! Models*): a white furnace stays white. The price is reciprocity, which is lost where that albedo depends on the
//! direction, so for rough surfaces near the horizon. In Mitsuba: `roughdielectric` with `distribution = ggx`, which does
//! not compensate.

use glam::{Vec2, Vec3};

use super::ggx::Ggx;
use super::{Scattered, fresnel};

/// Rough dielectric interface, seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct RoughGlass {
    /// Refractive index on the far side over that on the viewer's side.
    eta: f32,
    /// Tint of what crosses the interface, 0 … 1.
    transmittance: Vec3,
    ggx: Ggx,
    /// 1 ÷ what single scattering sends on in all.
    compensation: f32,
}

impl RoughGlass {
    /// An interface of GGX roughness `alpha` > 0, with `eta` times the viewer's refractive index beyond it, of which
    /// single scattering sends on the share `albedo` towards the viewer.
    pub fn new(eta: f32, transmittance: Vec3, alpha: f32, albedo: f32) -> Self {
        Self { eta, transmittance, ggx: Ggx::new(alpha), compensation: 1.0 / albedo }
    }

    /// Reflects about a visible facet with Fresnel's probability, refracts otherwise. Refracted radiance is scaled by
    /// 1/η², as by smooth glass.
    #[inline]
    pub(super) fn sample_direction(&self, outgoing: Vec3, choice: f32, u: Vec2) -> Option<Scattered> {
        let facet = self.ggx.sample_visible_normal(outgoing, u);
        let cosine = outgoing.dot(facet).clamp(0.0, 1.0);
        let (reflected, refracted_cosine) = fresnel::dielectric(cosine, self.eta);
        let (incoming, eta) = if choice < reflected {
            (2.0 * cosine * facet - outgoing, 1.0)
        } else {
            ((cosine / self.eta - refracted_cosine) * facet - outgoing / self.eta, self.eta)
        };
        if (incoming.z > 0.0) != (choice < reflected) {
            return None;
        }
        let incoming = incoming.normalize();
        let pdf = self.direction_pdf(outgoing, incoming);
        let weight = self.evaluate(outgoing, incoming) / pdf;
        (pdf > 0.0).then_some(Scattered { incoming, weight, pdf: Some(pdf), eta })
    }

    #[inline]
    pub(super) fn direction_pdf(&self, outgoing: Vec3, incoming: Vec3) -> f32 {
        let Some(facet) = self.facet(outgoing, incoming) else { return 0.0 };
        let visible = self.ggx.visible_density(outgoing, facet.normal);
        match facet.refracts {
            false => facet.reflected * visible / (4.0 * facet.cosine),
            true => (1.0 - facet.reflected) * visible * self.eta * self.eta * facet.spread(),
        }
    }

    #[inline]
    pub(super) fn evaluate(&self, outgoing: Vec3, incoming: Vec3) -> Vec3 {
        let Some(facet) = self.facet(outgoing, incoming) else { return Vec3::ZERO };
        match facet.refracts {
            false => {
                let (value, _) = self.ggx.evaluate(outgoing, incoming);
                Vec3::splat(self.compensation * facet.reflected * value)
            }
            true => {
                // Walter's equation 21 times cos θ of the incoming light, ÷ η² (see `sample_direction`).
                let visible = self.ggx.visible_density(outgoing, facet.normal) * self.ggx.masking(-incoming);
                self.compensation * (1.0 - facet.reflected) * visible * facet.spread() * self.transmittance
            }
        }
    }

    /// The facet that sends light from `incoming` to `outgoing`; `None` when no facet that shows to both does.
    #[inline]
    fn facet(&self, outgoing: Vec3, incoming: Vec3) -> Option<Facet> {
        let refracts = incoming.z < 0.0;
        let sum = if refracts { outgoing + self.eta * incoming } else { outgoing + incoming };
        let normal = sum.try_normalize()?;
        let normal = normal * normal.z.signum();
        let (cosine, incoming_cosine) = (outgoing.dot(normal), incoming.dot(normal));
        let faces_both = cosine > 0.0 && (incoming_cosine < 0.0) == refracts;
        let (reflected, _) = fresnel::dielectric(cosine.clamp(0.0, 1.0), self.eta);
        // The length of the sum is the cosines' own: outgoing·h + η incoming·h.
        let stretch = if refracts { sum.length_squared() } else { 1.0 };
        faces_both.then_some(Facet { normal, cosine, incoming_cosine, reflected, refracts, stretch })
    }
}

/// A microfacet between two directions.
struct Facet {
    normal: Vec3,
    cosine: f32,
    incoming_cosine: f32,
    /// Share of light it reflects.
    reflected: f32,
    refracts: bool,
    stretch: f32,
}

impl Facet {
    /// Solid angle of normals per solid angle of refracted light, ÷ η² (Walter's equation 17).
    #[inline]
    fn spread(&self) -> f32 {
        self.incoming_cosine.abs() / self.stretch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearly_smooth_glass_scatters_as_smooth_glass() {
        for eta in [1.5, 1.0 / 1.5] {
            let outgoing = Vec3::new(0.3, -0.4, 0.75_f32.sqrt());
            let rough = RoughGlass::new(eta, Vec3::splat(0.7), 2e-3, 1.0);
            let smooth = super::super::Glass { eta, transmittance: Vec3::splat(0.7) };
            for choice in [0.0, 0.9999] {
                let found = rough.sample_direction(outgoing, choice, Vec2::new(0.0, 0.3)).unwrap();
                let expected = smooth.sample_direction(outgoing, choice);
                assert!((found.incoming - expected.incoming).length() < 1e-4);
                assert!(
                    (found.weight - expected.weight).length() < 2e-3 * expected.weight.x,
                    "{} {}",
                    found.weight,
                    expected.weight
                );
                assert_eq!(found.eta, expected.eta);
            }
        }
    }
}
