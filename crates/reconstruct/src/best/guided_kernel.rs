//! An à trous kernel that does not cross borders: 5×5 B₃ splines with gaps, times a Gaussian of guide differences
//! (Dammertz et al. 2010).

mod piece;
mod smoothing;
mod taps;

use std::f32::consts::FRAC_1_SQRT_2;

use stack::{Image, Size};

use super::features::GuideFeatures;
pub use taps::Taps;

/// Planes whose differences separate pixels: a weight is exp(−Σ Δ²).
#[derive(Clone, Debug)]
pub struct GuidedKernel {
    size: Size,
    guides: Vec<Vec<f32>>,
}

impl GuidedKernel {
    /// A kernel for an image of `size`, guided by planes that are scaled already.
    pub fn new(size: Size, guides: Vec<Vec<f32>>) -> Self {
        Self { size, guides }
    }

    /// A kernel that stays on surfaces: features that differ by `scale` or more are kept apart.
    pub fn surfaces(features: &GuideFeatures, scale: f32) -> Self {
        Self::new(features.set.size, features.scaled_surfaces(FRAC_1_SQRT_2 / scale))
    }

    /// A kernel that stays on surfaces and among pixels of like brightness in `picture`: a squared difference of its
    /// logarithm counts `brightness` times one of a feature.
    pub fn surfaces_and_brightness(features: &GuideFeatures, picture: &Image, scale: f32, brightness: f32) -> Self {
        let mut kernel = Self::surfaces(features, scale);
        let factor = FRAC_1_SQRT_2 / scale * brightness.sqrt();
        let logarithm = |v: &f32| factor * (v + 0.02).max(0.01).ln();
        kernel.guides.extend(picture.channels().iter().map(|plane| plane.iter().map(logarithm).collect()));
        kernel
    }

    /// Smooths `planes` with taps `step` pixels apart.
    pub fn smooth(&self, planes: &[impl AsRef<[f32]>], step: usize) -> Vec<Vec<f32>> {
        self.taps(step).smooth(planes)
    }

    /// The kernel with taps `step` pixels apart, for as many planes as there are.
    pub fn taps(&self, step: usize) -> Taps {
        Taps::weighed(self.size, &self.guides, step)
    }
}

#[cfg(test)]
mod tests;
