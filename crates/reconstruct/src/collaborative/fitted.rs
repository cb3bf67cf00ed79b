//! What a collaborative fit works on.

use stack::Size;

use crate::eight::LANES;
use crate::patch_distance::PatchComparison;

/// Pictures that share their variance, each of which tells which pixels resemble each other.
#[derive(Clone, Copy, Debug)]
pub struct Guides<'a> {
    /// Width and height of every plane.
    pub size: Size,
    /// The planes of each picture, one per channel.
    pub values: &'a [&'a [Vec<f32>]],
    /// Variance of each value, one plane per channel, finite and ≥ 0.
    pub variances: &'a [Vec<f32>],
    /// How patches are compared.
    pub comparison: PatchComparison,
    /// Radius of the window, in pixels.
    pub radius: usize,
}

impl Guides<'_> {
    /// Pixels along a side of a window.
    pub fn side(&self) -> usize {
        2 * self.radius + 1
    }

    /// Groups of eight pixels that a row of a window needs.
    pub fn groups(&self) -> usize {
        self.side().div_ceil(LANES)
    }
}

/// Weight exp(−D/k² − d²/(2σ²)) of a pixel whose patch has distance D, d pixels away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    /// Bandwidth k of the guide.
    pub bandwidth: f32,
    /// Deviation σ in pixels; infinite where only the guide counts.
    pub sigma: f32,
}

/// What is fitted. Every plane has the size of the guides.
#[derive(Clone, Copy, Debug)]
pub struct Fitted<'a> {
    /// At most [`super::FEATURES`] planes that explain the responses.
    pub features: &'a [Vec<f32>],
    /// For each guide the planes that are fitted with its weights, at most [`super::RESPONSES`] in all.
    pub responses: &'a [&'a [&'a [f32]]],
    /// Factor on the weight of a residual, > 0; it does not touch the averaging of predictions. `None`: 1.
    pub importance: Option<&'a [f32]>,
    /// Relative variance ν of the responses, for the ridge.
    pub noise: &'a [f32],
    /// Strength of the ridge.
    pub ridge: Ridge,
    /// Distance between the pixels that carry a fit.
    pub stride: usize,
    /// A pixel on which the fits around it weigh less than this gets one of its own; a fit at the pixel itself weighs 1.
    pub covered: f32,
}

/// The ridge λ = `least` + `per_noise` · Σ k² ν/(Σ w)², added to the variance of every feature: the fewer and noisier
/// the pixels, the flatter the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ridge {
    /// λ without noise.
    pub least: f32,
    /// Factor on the noise.
    pub per_noise: f32,
}
