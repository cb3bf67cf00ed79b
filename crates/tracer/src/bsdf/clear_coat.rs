//! A clear coat over another surface: varnish on wood, lacquer on car paint.
//!
//! A GGX surface with Schlick's Fresnel, of glass of index 1.5, and with what its facets reflect more than once (see
//! `conductor`). Where it covers the share w of the surface, and with its directional albedo E,
//!
//! f = w f_coat + (1 − w E(o)) f_below.
//!
//! What the coat does not reflect towards the viewer is left to what lies below, as in the specification of
//! `KHR_materials_clearcoat`, OpenPBR and Cycles (there called albedo scaling): a white furnace stays white whatever is below,
//! mirrors too. The factor (1 − w E(o)) (1 − w E(i)) / (1 − w Ē) of `coated` would be reciprocal, but a mirror below it reflects
//! more than everything where one looks straight down. The price is reciprocity near the horizon.
//!
//! The coat has a normal of its own: carbon fibre and flakes below smooth lacquer do not show in what that mirrors.

use glam::{Vec2, Vec3};

use super::frame::{Frame, above};
use super::ggx::Ggx;
use super::{coat_albedo, fresnel};

/// Reflectance at normal incidence.
pub(super) const REFLECTANCE: f32 = 0.04;

/// A coat is never smoother than this: nobody sees the difference, and the surface keeps one kind of event.
const SMOOTHEST: f32 = 1e-3;

/// A clear coat, seen from one direction of the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClearCoat {
    frame: Frame,
    local_outgoing: Vec3,
    ggx: Ggx,
    /// What facets reflect in all, seen from along their normal and from the side, times the share that they cover.
    facets: [f32; 2],
    /// Share of light that is left to what lies below.
    pub(super) passed: f32,
    /// Probability of sampling the coat.
    pub(super) share: f32,
}

impl ClearCoat {
    /// A coat of GGX roughness `alpha` with the unit normal `normal` that covers the share `cover` of a surface of albedo
    /// `below` (all 0 … 1), seen from the unit vector `outgoing`, on the normal's side.
    pub(super) fn new(cover: f32, alpha: f32, normal: Vec3, outgoing: Vec3, below: Vec3) -> Self {
        let alpha = alpha.clamp(SMOOTHEST, 1.0);
        let frame = Frame::new(normal);
        let local_outgoing = above(frame.to_local(outgoing));
        let specular = Vec3::splat(REFLECTANCE);
        let seen = coat_albedo::at_roughness(alpha).directional(local_outgoing.z);
        let more = seen.compensation(specular).x;
        let reflected = cover * seen.reflected(specular).x;
        let passed = 1.0 - reflected;
        let share = reflected / (reflected + passed * below.element_sum() / 3.0);
        let facets = [cover * REFLECTANCE * more, cover * more];
        Self { frame, local_outgoing, ggx: Ggx::new(alpha), facets, passed, share }
    }

    /// Its normal, on the viewer's side.
    #[inline]
    pub(super) fn normal(&self) -> Vec3 {
        self.frame.to_world(Vec3::Z)
    }

    /// A direction of the world that light comes from, in proportion to what the coat's visible facets reflect. `None` where it
    /// would come from below.
    pub(super) fn sample_direction(&self, u: Vec2) -> Option<Vec3> {
        Some(self.frame.to_world(self.ggx.sample_reflection(self.local_outgoing, u)?.incoming))
    }

    /// Density per solid angle of [`sample_direction`](Self::sample_direction).
    pub(super) fn direction_pdf(&self, incoming: Vec3) -> f32 {
        let local = self.frame.to_local(incoming);
        if local.z > 0.0 { self.ggx.reflection_pdf(self.local_outgoing, local) } else { 0.0 }
    }

    /// f·cos θ of the coat alone, for light from the unit vector `incoming` of the world.
    pub(super) fn evaluate(&self, incoming: Vec3) -> f32 {
        let local = self.frame.to_local(incoming);
        if local.z <= 0.0 {
            return 0.0;
        }
        let (value, facet_cosine) = self.ggx.evaluate(self.local_outgoing, local);
        let [facing, sideways] = self.facets;
        value * (facing + (sideways - facing) * fresnel::schlick_weight(facet_cosine))
    }
}
