//! Something a stack does not have.

use std::fmt;

/// Something a stack does not have, and what was used in its stead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lack {
    /// What is missing.
    pub what: &'static str,
    /// What was used in its stead.
    pub instead: &'static str,
}

impl Lack {
    /// Neither buckets nor half-buffers, but a variance.
    pub const HALVES: Self =
        Self { what: "buckets or half-buffers of the colour", instead: "two halves were drawn from its variance" };
    /// Nothing about the noise of colour.
    pub const NOISE: Self = Self {
        what: "buckets, half-buffers or variance of the colour",
        instead: "its noise was measured on the picture, which takes some detail for noise",
    };
    /// No position, but depth.
    pub const POSITION: Self = Self { what: "position", instead: "depth and the place on the screen were used" };
    /// Neither position nor depth.
    pub const PLACE: Self = Self { what: "position or depth", instead: "the place on the screen was used" };
    /// Nothing that tells textures.
    pub const ALBEDO: Self = Self { what: "albedo", instead: "the picture, freed of noise, tells textures" };
    /// Albedo that stops at mirrors.
    pub const MIRRORED: Self = Self {
        what: "albedo on mirrors, glass or metal",
        instead: "the picture, freed of noise, tells what they show",
    };
    /// No feature at all.
    pub const FEATURES: Self =
        Self { what: "features", instead: "the colour guides itself; albedo and normal would help most" };
}

impl fmt::Display for Lack {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no {}: {}", self.what, self.instead)
    }
}
