//! Clear smooth dielectric: exact Fresnel reflection and refraction (pbrt-v4, section 9.5). Mitsuba's `dielectric`.

use glam::Vec3;

use super::{Scattered, fresnel};

/// Smooth dielectric interface, seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct Glass {
    /// Refractive index on the far side over that on the viewer's side.
    pub eta: f32,
    /// Tint of what crosses the interface, 0 … 1.
    pub transmittance: Vec3,
}

impl Glass {
    /// Reflects with Fresnel's probability, refracts otherwise. Refracted radiance is scaled by 1/η²: beyond the
    /// interface the same light fills another solid angle.
    #[inline]
    pub(super) fn sample_direction(&self, outgoing: Vec3, choice: f32) -> Scattered {
        let (reflected, refracted_cosine) = fresnel::dielectric(outgoing.z, self.eta);
        if choice < reflected {
            let incoming = Vec3::new(-outgoing.x, -outgoing.y, outgoing.z);
            return Scattered { incoming, weight: Vec3::ONE, pdf: None, eta: 1.0 };
        }
        let incoming = Vec3::new(-outgoing.x / self.eta, -outgoing.y / self.eta, -refracted_cosine).normalize();
        Scattered { incoming, weight: self.transmittance / (self.eta * self.eta), pdf: None, eta: self.eta }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refraction_obeys_snell_and_returns_on_its_own_path() {
        for eta in [1.5, 1.0 / 1.5, 1.0] {
            let outgoing = Vec3::new(0.3, -0.4, 0.75_f32.sqrt());
            let glass = Glass { eta, transmittance: Vec3::ONE };
            let there = glass.sample_direction(outgoing, 0.999);
            let sin = |v: Vec3| v.truncate().length();
            assert!((sin(outgoing) - eta * sin(there.incoming)).abs() < 1e-6);
            assert_eq!(there.eta, eta);
            let back = Glass { eta: 1.0 / eta, ..glass };
            // Seen from beyond, the normal is the other one.
            let turned = |v: Vec3| Vec3::new(v.x, v.y, -v.z);
            let returned = back.sample_direction(turned(there.incoming), 0.999);
            assert!((turned(returned.incoming) - outgoing).length() < 1e-5);
            assert!((there.weight * returned.weight - Vec3::ONE).length() < 1e-5);
        }
    }

    #[test]
    fn the_choice_reflects_with_fresnel_s_probability() {
        let glass = Glass { eta: 1.5, transmittance: Vec3::ONE };
        assert!(glass.sample_direction(Vec3::Z, 0.0399).incoming.z > 0.0);
        assert!(glass.sample_direction(Vec3::Z, 0.0401).incoming.z < 0.0);
        let inside = Glass { eta: 1.0 / 1.5, transmittance: Vec3::ONE };
        let flat = Vec3::new(0.8, 0.0, 0.6);
        assert!(inside.sample_direction(flat, 0.999_999).incoming.z > 0.0, "total reflection");
    }
}
