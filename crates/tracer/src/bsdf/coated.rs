//! A diffuse base under a rough specular coat.
//!
//! The coat is a GGX surface with Schlick's Fresnel, and with what its facets reflect more than once, as of metal (see
//! `conductor`); with directional albedo E(o) and mean albedo Ē = 2∫E(μ)μdμ,
//!
//! f = f_coat + k_d/π · (1 − E(o)) (1 − E(i)) / (1 − Ē)        (Kelemen and Szirmay-Kalos 2001, per colour channel).
//!
//! What the coat does not reflect enters the base, and leaves it by the same rule: the albedo is E(o) + k_d (1 − E(o)) ≤ 1
//! at every angle, however bright `diffuse` and `specular` are. The base is reciprocal; the coat is but for the factor that
//! gives back multiple scattering, which a coat of 0.04 hardly has.
//!
//! Where the surface is metal in part, f = (1 − metallic) f + metallic f_metal, the metal being of the base's colour: as
//! bright as its parts, and the same as a metal when nothing else is left.
//!
//! In Mitsuba, with `int_ior` = (1 + √F₀)/(1 − √F₀), `diffuse_reflectance` = k_d, `nonlinear = false`, grey `specular`:
//! `plastic` has the same base as a smooth coat here (α → 0), because its 1 − fdr_int is (1 − Ē)/η² by reciprocity; with
//! Fresnel's equations in place of Schlick's approximation. Measured at F₀ = 0.04, α = 0.01: 2 % apart, 5 % at a
//! cosine of 0.2. `roughplastic` with `distribution = ggx` has the same coat, but its base also loses what rough
//! *transmission* loses between facets, so that it is darker: by 2 % at α = 0.01, 10 % at 0.1, 58 % at 0.7, towards a
//! viewer near the normal. `principled` with `roughness` = √α, `specular` = 0.5 (F₀ = 0.04) is nearest for rough coats:
//! within 5 % there, but brighter near the horizon, where its base is not Lambertian.
//!
//! OBJ's K_d, K_s, N_s map to `diffuse`, `specular`, α = √(2/(N_s + 2)).

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Vec2, Vec3};

use super::coat_albedo::{self, CoatAlbedo, grazing};
use super::ggx::Ggx;
use super::{Scattered, fresnel};
use crate::sampler::warp::{cosine_hemisphere_pdf, sample_cosine_hemisphere};

/// A coat is never smoother than this: nobody sees the difference, and the surface keeps one kind of event.
const SMOOTHEST: f32 = 1e-3;

/// Diffuse under a rough coat, seen from one direction.
#[derive(Clone, Copy, Debug)]
pub struct Coated {
    /// k_d / (1 − Ē) / π · (1 − E(o)), of what is no metal.
    base: Vec3,
    /// Reflectance of the coat over the base at normal incidence.
    specular: Vec3,
    /// What facets of coat and metal reflect in all, seen from along their normal and from the side.
    facets: [Vec3; 2],
    ggx: Ggx,
    albedo: CoatAlbedo,
    /// Probability of sampling the coat.
    coat_share: f32,
}

impl Coated {
    /// A base of reflectance `diffuse` under a coat that reflects `specular` at normal incidence, of which the share
    /// `metallic` is a metal of the base's colour (all 0 … 1), of GGX roughness `alpha`, seen with cosine `outgoing_cosine`.
    pub fn new(diffuse: Vec3, specular: Vec3, metallic: f32, alpha: f32, outgoing_cosine: f32) -> Self {
        let alpha = alpha.clamp(SMOOTHEST, 1.0);
        let albedo = coat_albedo::at_roughness(alpha);
        let seen = albedo.directional(outgoing_cosine);
        let below = (1.0 - metallic) * diffuse;
        let base = below * seen.passed_shape(specular) / albedo.mean().passed_shape(specular) * FRAC_1_PI;
        let mixed = |coat: Vec3, metal: Vec3| coat.lerp(metal, metallic);
        let more = [specular, diffuse].map(|reflectance| seen.compensation(reflectance));
        let facets = [
            mixed(specular * more[0], diffuse * more[1]),
            mixed(grazing(specular) * more[0], grazing(diffuse) * more[1]),
        ];
        let coat = mixed(seen.reflected(specular), seen.reflected(diffuse)).element_sum();
        let below = (below * seen.passed(specular)).element_sum();
        let coat_share = if coat + below > 0.0 { coat / (coat + below) } else { 0.0 };
        Self { base, specular, facets, ggx: Ggx::new(alpha), albedo, coat_share }
    }

    #[inline]
    pub(super) fn sample_direction(&self, outgoing: Vec3, choice: f32, u: Vec2) -> Option<Scattered> {
        let incoming = if choice < self.coat_share {
            self.ggx.sample_reflection(outgoing, u)?.incoming
        } else {
            sample_cosine_hemisphere(u)
        };
        let pdf = self.direction_pdf(outgoing, incoming);
        if incoming.z <= 0.0 || pdf <= 0.0 {
            return None;
        }
        Some(Scattered { incoming, weight: self.evaluate(outgoing, incoming) / pdf, pdf: Some(pdf), eta: 1.0 })
    }

    #[inline]
    pub(super) fn direction_pdf(&self, outgoing: Vec3, incoming: Vec3) -> f32 {
        self.coat_share * self.ggx.reflection_pdf(outgoing, incoming)
            + (1.0 - self.coat_share) * cosine_hemisphere_pdf(incoming.z)
    }

    #[inline]
    pub(super) fn evaluate(&self, outgoing: Vec3, incoming: Vec3) -> Vec3 {
        let (coat, facet_cosine) = self.ggx.evaluate(outgoing, incoming);
        let [facing, sideways] = self.facets;
        coat * facing.lerp(sideways, fresnel::schlick_weight(facet_cosine)) + self.evaluate_base(incoming)
    }

    /// The part of [`evaluate`](Self::evaluate) that light takes through the base.
    #[inline]
    pub(super) fn evaluate_base(&self, incoming: Vec3) -> Vec3 {
        self.base * self.albedo.directional(incoming.z).passed(self.specular) * incoming.z
    }

    /// What the base reflects to the viewer of light that is even below the coat: π times its radiance.
    #[inline]
    pub(super) fn base_albedo(&self) -> Vec3 {
        PI * self.base
    }
}
