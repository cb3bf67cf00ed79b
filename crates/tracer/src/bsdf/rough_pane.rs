//! A thin pane of frosted glass: what GGX facets would mirror goes back or, turned over, through.
//!
//! As `KHR_materials_transmission` has it: the lobe of what passes is that of what a mirror of the same roughness reflects, seen
//! from the other side. Every facet reflects as a clear pane does (see `thin_glass`). What facets scatter more than once is given
//! back as in `conductor`, so that a white furnace stays white.

use glam::{Vec2, Vec3};

use super::ggx::Ggx;
use super::{Scattered, thin_glass};

/// A pane with a rough surface, seen from either side.
#[derive(Clone, Copy, Debug)]
pub struct RoughPane {
    ior: f32,
    /// Tint of what passes, 0 … 1.
    transmittance: Vec3,
    ggx: Ggx,
    /// 1 ÷ what perfectly reflecting facets send on after a single event.
    compensation: f32,
}

impl RoughPane {
    /// A pane of refractive index `ior` and GGX roughness `alpha` > 0, of which perfectly reflecting facets would reflect the
    /// share `albedo` towards the viewer in a single event.
    pub fn new(ior: f32, transmittance: Vec3, alpha: f32, albedo: f32) -> Self {
        Self { ior, transmittance, ggx: Ggx::new(alpha), compensation: 1.0 / albedo }
    }

    /// Reflects about a visible facet with its probability, else goes where the mirror image of that lies.
    #[inline]
    pub(super) fn sample_direction(&self, outgoing: Vec3, choice: f32, u: Vec2) -> Option<Scattered> {
        let sample = self.ggx.sample_reflection(outgoing, u)?;
        let reflected = thin_glass::reflected(self.ior, sample.facet_cosine);
        let density = self.ggx.reflection_pdf(outgoing, sample.incoming);
        let weight = self.compensation * sample.weight;
        Some(if choice < reflected {
            let pdf = Some(reflected * density);
            Scattered { incoming: sample.incoming, weight: Vec3::splat(weight), pdf, eta: 1.0 }
        } else {
            let pdf = Some((1.0 - reflected) * density);
            Scattered { incoming: turned(sample.incoming), weight: weight * self.transmittance, pdf, eta: 1.0 }
        })
    }

    #[inline]
    pub(super) fn direction_pdf(&self, outgoing: Vec3, incoming: Vec3) -> f32 {
        let mirrored = raised(incoming);
        let reflected = thin_glass::reflected(self.ior, facet_cosine(outgoing, mirrored));
        let share = if incoming.z > 0.0 { reflected } else { 1.0 - reflected };
        share * self.ggx.reflection_pdf(outgoing, mirrored)
    }

    #[inline]
    pub(super) fn evaluate(&self, outgoing: Vec3, incoming: Vec3) -> Vec3 {
        let (value, cosine) = self.ggx.evaluate(outgoing, raised(incoming));
        let reflected = thin_glass::reflected(self.ior, cosine);
        let share = if incoming.z > 0.0 { Vec3::splat(reflected) } else { (1.0 - reflected) * self.transmittance };
        self.compensation * value * share
    }
}

fn turned(direction: Vec3) -> Vec3 {
    direction * Vec3::new(1.0, 1.0, -1.0)
}

/// `direction` or its mirror image, whichever is above the pane.
fn raised(direction: Vec3) -> Vec3 {
    direction.with_z(direction.z.abs())
}

fn facet_cosine(outgoing: Vec3, incoming: Vec3) -> f32 {
    outgoing.dot((outgoing + incoming).normalize()).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hardly_rough_pane_scatters_as_a_clear_one() {
        let clear = super::super::ThinGlass { ior: 1.5, transmittance: Vec3::splat(0.7) };
        let rough = RoughPane::new(1.5, Vec3::splat(0.7), 2e-3, 1.0);
        let outgoing = Vec3::new(0.3, -0.4, 0.75_f32.sqrt());
        for choice in [0.0, 0.9999] {
            let found = rough.sample_direction(outgoing, choice, Vec2::new(0.0, 0.3)).unwrap();
            let expected = clear.sample_direction(outgoing, choice);
            assert!((found.incoming - expected.incoming).length() < 1e-4, "{choice}");
            assert!((found.weight - expected.weight).length() < 1e-3, "{choice}");
        }
    }
}
