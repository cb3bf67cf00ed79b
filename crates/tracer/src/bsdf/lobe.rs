//! One way of scattering, in a local frame.

use glam::{Vec2, Vec3};

use super::{Coated, Conductor, Diffuse, Glass, Mirror, RoughGlass, RoughPane, ThinGlass};

/// A direction that a lobe has chosen, in its local frame.
#[derive(Clone, Copy, Debug)]
pub struct Scattered {
    /// Where the light comes from; unit length.
    pub incoming: Vec3,
    /// f·|cos θ| ÷ pdf.
    pub weight: Vec3,
    /// Density per solid angle; `None` when the direction was the only one possible (a delta distribution).
    pub pdf: Option<f32>,
    /// Refractive index on the incoming side over that on the outgoing side; 1 when reflected.
    pub eta: f32,
}

/// One way of scattering. In all methods +z is the normal, and `outgoing` a unit vector with z > 0.
#[derive(Clone, Copy, Debug)]
pub enum Lobe {
    /// Lambertian.
    Diffuse(Diffuse),
    /// Perfect mirror.
    Mirror(Mirror),
    /// Smooth dielectric.
    Glass(Glass),
    /// Pane of glass.
    ThinGlass(ThinGlass),
    /// Rough dielectric.
    RoughGlass(RoughGlass),
    /// Frosted pane.
    RoughPane(RoughPane),
    /// Rough metal.
    Conductor(Conductor),
    /// Diffuse under a rough coat.
    Coated(Coated),
}

impl Lobe {
    /// Whether it scatters into single directions only, which nothing but sampling can find.
    #[inline]
    pub const fn is_specular(&self) -> bool {
        matches!(self, Self::Mirror(_) | Self::Glass(_) | Self::ThinGlass(_))
    }

    /// Whether light passes through it.
    #[inline]
    pub const fn is_glass(&self) -> bool {
        matches!(self, Self::Glass(_) | Self::ThinGlass(_) | Self::RoughGlass(_) | Self::RoughPane(_))
    }

    /// Whether it looks equally bright from all sides.
    #[inline]
    pub const fn is_diffuse(&self) -> bool {
        matches!(self, Self::Diffuse(_))
    }

    /// What a part of it reflects that looks equally bright from all sides, but for a factor that this includes; `None`
    /// where there is no such part.
    #[inline]
    pub fn even_albedo(&self) -> Option<Vec3> {
        match self {
            Self::Diffuse(diffuse) => Some(diffuse.reflectance),
            Self::Coated(coated) => Some(coated.base_albedo()).filter(|albedo| *albedo != Vec3::ZERO),
            _ => None,
        }
    }

    /// The share of that part in [`evaluate`](Self::evaluate).
    #[inline]
    pub fn even_share(&self, outgoing: Vec3, incoming: Vec3) -> Vec3 {
        match self {
            Self::Diffuse(_) => Vec3::ONE,
            Self::Coated(coated) if incoming.z > 0.0 => {
                let all = coated.evaluate(outgoing, incoming).max(Vec3::splat(f32::MIN_POSITIVE));
                (coated.evaluate_base(incoming) / all).min(Vec3::ONE)
            }
            _ => Vec3::ZERO,
        }
    }

    /// Whether light from beyond the surface matters to [`evaluate`](Self::evaluate).
    #[inline]
    pub const fn is_two_sided(&self) -> bool {
        matches!(self, Self::RoughGlass(_) | Self::RoughPane(_))
    }

    /// Chooses a direction for the light that leaves towards `outgoing`, from a number `choice` in [0, 1) and a point
    /// `u` in [0, 1)². `None` when the light is absorbed.
    #[inline]
    pub fn sample_direction(&self, outgoing: Vec3, choice: f32, u: Vec2) -> Option<Scattered> {
        match self {
            Self::Diffuse(diffuse) => diffuse.sample_direction(u),
            Self::Mirror(mirror) => Some(mirror.sample_direction(outgoing)),
            Self::Glass(glass) => Some(glass.sample_direction(outgoing, choice)),
            Self::ThinGlass(pane) => Some(pane.sample_direction(outgoing, choice)),
            Self::RoughGlass(glass) => glass.sample_direction(outgoing, choice, u),
            Self::RoughPane(pane) => pane.sample_direction(outgoing, choice, u),
            Self::Conductor(conductor) => conductor.sample_direction(outgoing, u),
            Self::Coated(coated) => coated.sample_direction(outgoing, choice, u),
        }
    }

    /// Density per solid angle of [`sample_direction`](Self::sample_direction); 0 for specular lobes. It integrates to
    /// the share of samples that are not absorbed.
    #[inline]
    pub fn direction_pdf(&self, outgoing: Vec3, incoming: Vec3) -> f32 {
        match self {
            Self::RoughGlass(glass) => glass.direction_pdf(outgoing, incoming),
            Self::RoughPane(pane) => pane.direction_pdf(outgoing, incoming),
            _ if incoming.z <= 0.0 => 0.0,
            Self::Diffuse(diffuse) => diffuse.direction_pdf(incoming),
            Self::Conductor(conductor) => conductor.direction_pdf(outgoing, incoming),
            Self::Coated(coated) => coated.direction_pdf(outgoing, incoming),
            Self::Mirror(_) | Self::Glass(_) | Self::ThinGlass(_) => 0.0,
        }
    }

    /// f·cos θ for light from `incoming`; 0 for specular lobes.
    #[inline]
    pub fn evaluate(&self, outgoing: Vec3, incoming: Vec3) -> Vec3 {
        match self {
            Self::RoughGlass(glass) => glass.evaluate(outgoing, incoming),
            Self::RoughPane(pane) => pane.evaluate(outgoing, incoming),
            _ if incoming.z <= 0.0 => Vec3::ZERO,
            Self::Diffuse(diffuse) => diffuse.evaluate(incoming),
            Self::Conductor(conductor) => conductor.evaluate(outgoing, incoming),
            Self::Coated(coated) => coated.evaluate(outgoing, incoming),
            Self::Mirror(_) | Self::Glass(_) | Self::ThinGlass(_) => Vec3::ZERO,
        }
    }
}
