//! A pane of clear glass too thin to shift what is seen through it. Mitsuba's `thindielectric`.

use glam::Vec3;

use super::{Scattered, fresnel};

/// Two parallel smooth interfaces with nothing between them, seen from either side.
#[derive(Clone, Copy, Debug)]
pub struct ThinGlass {
    /// Refractive index of the glass over that of what surrounds it.
    pub ior: f32,
    /// Tint of what passes, 0 … 1.
    pub transmittance: Vec3,
}

impl ThinGlass {
    /// Reflects or goes straight on.
    #[inline]
    pub(super) fn sample_direction(&self, outgoing: Vec3, choice: f32) -> Scattered {
        if choice < reflected(self.ior, outgoing.z) {
            let incoming = Vec3::new(-outgoing.x, -outgoing.y, outgoing.z);
            return Scattered { incoming, weight: Vec3::ONE, pdf: None, eta: 1.0 };
        }
        Scattered { incoming: -outgoing, weight: self.transmittance, pdf: None, eta: 1.0 }
    }
}

/// Share of light that a pane of refractive index `ior` reflects, met with cosine `cosine`. Light that bounces between the
/// interfaces adds up: with r of each, all reflect r + (1 − r)² r (1 + r² + r⁴ …) = 2r/(1 + r).
#[inline]
pub(super) fn reflected(ior: f32, cosine: f32) -> f32 {
    let (once, _) = fresnel::dielectric(cosine, ior.max(1.0 / ior));
    2.0 * once / (1.0 + once)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_goes_straight_on_or_is_reflected_by_both_interfaces() {
        let pane = ThinGlass { ior: 1.5, transmittance: Vec3::splat(0.5) };
        // 0.04 + 0.96² · 0.04 + …: 2 · 0.04 / 1.04 in all.
        let share = 0.08 / 1.04;
        let outgoing = Vec3::new(1e-4, 0.0, 1.0).normalize();
        assert_eq!(pane.sample_direction(outgoing, share - 1e-4).incoming.x, -outgoing.x);
        let through = pane.sample_direction(outgoing, share + 1e-4);
        assert_eq!((through.incoming, through.weight, through.eta), (-outgoing, Vec3::splat(0.5), 1.0));
        let bubble = ThinGlass { ior: 1.0 / 1.5, ..pane };
        assert!(bubble.sample_direction(Vec3::new(0.99, 0.0, 0.141), 0.999).incoming.z < 0.0, "no total reflection");
    }
}
