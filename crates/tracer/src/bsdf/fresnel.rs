//! How much an interface reflects.

use glam::Vec3;

/// Share of unpolarised light that a smooth interface between dielectrics reflects (Fresnel's equations), for light
/// that meets it with cosine `cosine` ≥ 0 from a side whose refractive index is the other side's ÷ `eta`; and the
/// cosine of the refracted direction (0 on total reflection, where the share is 1).
#[inline]
pub(super) fn dielectric(cosine: f32, eta: f32) -> (f32, f32) {
    let sin2_refracted = (1.0 - cosine * cosine).max(0.0) / (eta * eta);
    if sin2_refracted >= 1.0 {
        return (1.0, 0.0);
    }
    let refracted = (1.0 - sin2_refracted).sqrt();
    let parallel = (eta * cosine - refracted) / (eta * cosine + refracted);
    let perpendicular = (cosine - eta * refracted) / (cosine + eta * refracted);
    (0.5 * (parallel * parallel + perpendicular * perpendicular), refracted)
}

/// (1 − cosine)⁵: how far Schlick's approximation has gone from the reflectance at normal incidence to 1.
#[inline]
pub(super) fn schlick_weight(cosine: f32) -> f32 {
    let m = (1.0 - cosine).clamp(0.0, 1.0);
    let m2 = m * m;
    m2 * m2 * m
}

/// Schlick's approximation (1994) of a reflectance that is `normal_incidence` at cosine 1 and 1 at cosine 0.
#[inline]
pub(super) fn schlick(normal_incidence: Vec3, cosine: f32) -> Vec3 {
    normal_incidence + (Vec3::ONE - normal_incidence) * schlick_weight(cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_matches_its_closed_forms() {
        // Normal incidence: ((η − 1)/(η + 1))². Brewster's angle: the parallel part vanishes.
        assert!((dielectric(1.0, 1.5).0 - 0.04).abs() < 1e-6);
        assert!((dielectric(1.0, 1.0 / 1.5).0 - 0.04).abs() < 1e-6);
        let brewster = 1.5_f32.atan();
        let expected = 0.5 * (2.0 * brewster).cos().powi(2);
        assert!((dielectric(brewster.cos(), 1.5).0 - expected).abs() < 1e-6);
        assert!((dielectric(1e-6, 1.5).0 - 1.0).abs() < 1e-4);
    }

    #[test]
    fn total_reflection_begins_at_the_critical_angle() {
        let critical = (1.0_f32 / 1.5).asin();
        assert_eq!(dielectric((critical + 1e-3).cos(), 1.0 / 1.5), (1.0, 0.0));
        assert!(dielectric((critical - 1e-3).cos(), 1.0 / 1.5).0 < 1.0);
    }

    #[test]
    fn an_interface_reflects_alike_from_both_sides() {
        for cosine in [0.1, 0.5, 0.9] {
            let (from_outside, refracted) = dielectric(cosine, 1.5);
            let (from_inside, back) = dielectric(refracted, 1.0 / 1.5);
            assert!((from_outside - from_inside).abs() < 1e-5);
            assert!((back - cosine).abs() < 1e-5);
        }
    }

    #[test]
    fn schlick_stays_near_fresnel() {
        for i in 1..=20 {
            let cosine = i as f32 / 20.0;
            let difference = schlick(Vec3::splat(0.04), cosine).x - dielectric(cosine, 1.5).0;
            assert!(difference.abs() < 0.05, "{cosine}: {difference}");
        }
    }
}
