//! Where a path finds light that it shares with others.

use glam::Vec3;

use super::place::{DIGITS, Place};
use crate::bsdf::Bsdf;
use crate::bvh::Bounds;
use crate::interaction::Interaction;

/// Largest cell that paths share, against what one path stands for: the directions of its kind, as far away as it went.
/// Larger ones would blur what lies next to a surface or is seen in its gloss.
pub(super) const WIDEST: f32 = 0.35;

/// A point on a diffuse surface, or on the base of a coated one, that a path went on to from the surface that is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GatherPoint {
    pub(super) place: Place,
    /// Radiance at the camera ÷ (radiance that leaves the point ÷ its albedo).
    pub(super) weight: Vec3,
    /// Radiance at the camera that the path by itself found to come from here.
    pub(crate) found: Vec3,
    /// How many levels of cells, from the smallest, may stand for the point.
    pub(super) levels: u8,
}

impl GatherPoint {
    /// The point `hit` of a surface that scatters as `bsdf` says and has an even part, reached with `throughput` by a path
    /// that stands for a solid angle of `spread`², in a scene of those `bounds`. `None` where it has none.
    pub(crate) fn new(hit: &Interaction, bsdf: &Bsdf, throughput: Vec3, spread: f32, bounds: Bounds) -> Option<Self> {
        let albedo = bsdf.even_albedo()?;
        let steps = (1 << DIGITS) as f32 / bounds.extent().max_element();
        Some(Self {
            place: Place::new((hit.position - bounds.min) * steps, hit.facing_normal(), !bsdf.is_diffuse()),
            weight: throughput * albedo,
            found: Vec3::ZERO,
            levels: levels_within(WIDEST * spread * hit.distance * steps),
        })
    }

    /// Whether it lies on the base of a coated surface.
    pub(crate) const fn is_coated(&self) -> bool {
        self.place.is_coated()
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.weight.is_finite() && self.found.is_finite()
    }

    /// What leaves the point ÷ its albedo, as the path found it, times how much that counts; and this. Of coated surfaces
    /// paths count by their weight: together they take what they brought, though a coat sends those on that weigh little.
    /// `None` where the path or the surface is blind to a colour.
    pub(super) fn leaving(&self) -> Option<[Vec3; 2]> {
        let counts = if self.is_coated() { self.weight } else { Vec3::ONE };
        (self.weight.min_element() > 0.0).then(|| [self.found / self.weight * counts, counts])
    }
}

/// How many levels have cells no larger than `size`, in steps of a place.
pub(super) fn levels_within(size: f32) -> u8 {
    // Saturates at 0.
    (size.log2().floor() + 1.0) as u8
}
