//! An edge-avoiding à trous kernel (Dammertz et al. 2010): 5×5 B₃ splines with gaps, times a Gaussian of how far apart
//! pixels are in planes that tell surfaces, and perhaps brightness, apart.

mod piece;
mod seamless;
mod smoothing;
mod taps;

use stack::{Image, Size};

use super::features::CleanFeatures;
use super::light_features::logarithm;
use crate::per_pixel::plane;
pub use seamless::Seamless;
use taps::Separation;
pub use taps::Taps;

/// Planes whose differences separate pixels: a weight is exp(−Σ Δ²/(2 s²)) with the scale s. Features are borrowed:
/// a scaled copy would take 36 bytes a pixel where a reconstruction needs the most memory.
#[derive(Clone, Debug)]
pub struct EdgeAvoidingKernel<'a> {
    size: Size,
    separators: Vec<&'a [f32]>,
    brightness: Vec<Vec<f32>>,
    scale: f32,
}

impl<'a> EdgeAvoidingKernel<'a> {
    /// A kernel for an image of `size` that keeps pixels apart whose values differ by `scale` or more in `separators`.
    pub fn new(size: Size, separators: Vec<&'a [f32]>, scale: f32) -> Self {
        Self { size, separators, brightness: Vec::new(), scale }
    }

    /// A kernel that stays on surfaces: features that differ by `scale` or more are kept apart.
    pub fn on_surfaces(features: &'a CleanFeatures, scale: f32) -> Self {
        Self::new(features.set.size, features.separators().collect(), scale)
    }

    /// A kernel that stays on surfaces and among pixels of like brightness in `picture`: a squared difference of its
    /// logarithm counts `brightness` times one of a feature.
    pub fn on_surfaces_of_like_brightness(
        features: &'a CleanFeatures,
        picture: &Image,
        scale: f32,
        brightness: f32,
    ) -> Self {
        let weight = brightness.sqrt();
        let weighed = |values: &Vec<f32>| plane(values.len(), |pixel| weight * logarithm(values[pixel]));
        let brightness = picture.channels().iter().map(weighed).collect();
        Self { brightness, ..Self::on_surfaces(features, scale) }
    }

    /// The share of each pixel's surroundings that is on its surface and in the picture, as `levels` kernels one after the
    /// other weigh it, each twice as wide: 1 inside of a surface, 1/2 at a straight edge.
    pub fn mass(&self, levels: usize) -> Vec<f32> {
        (0..levels).fold(vec![1.0; self.size.pixels()], |mass, level| self.taps(1 << level).sum(&mass))
    }

    /// Smooths `planes` with taps `step` pixels apart.
    pub fn smooth(&self, planes: &[impl AsRef<[f32]>], step: usize) -> Vec<Vec<f32>> {
        self.taps(step).smooth(planes)
    }

    /// The kernel with taps `step` pixels apart, for as many planes as there are.
    pub fn taps(&self, step: usize) -> Taps {
        let brightness = self.brightness.iter().map(Vec::as_slice);
        let planes = self.separators.iter().copied().chain(brightness).collect();
        Taps::weighed(self.size, &Separation { planes, per_square: 0.5 / (self.scale * self.scale) }, step)
    }
}

#[cfg(test)]
mod tests;
