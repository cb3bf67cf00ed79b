//! What a collaborative fit works on.

use super::row::Row;
use crate::patch_distance::{Comparison, NoisyPlanes};

/// Which pixels resemble each other.
#[derive(Clone, Copy, Debug)]
pub struct Guide<'a> {
    /// The planes that are compared.
    pub planes: NoisyPlanes<'a>,
    /// How their patches are compared.
    pub comparison: Comparison,
    /// Radius of the window, in pixels.
    pub radius: usize,
}

/// Weight exp(−D/k² − d²/(2σ²)) of a pixel whose patch has distance D, d pixels away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    /// Bandwidth k of the guide.
    pub bandwidth: f32,
    /// Deviation σ in pixels; infinite where only the guide counts.
    pub sigma: f32,
}

/// What is fitted. Everything has the size of the guide.
#[derive(Clone, Copy, Debug)]
pub struct Fitted<'a> {
    /// Features and responses.
    pub rows: &'a [Row],
    /// Factor on the weight of a residual, > 0; it does not touch the averaging of predictions. `None`: 1.
    pub importance: Option<&'a [f32]>,
    /// Relative variance ν of the responses, for the ridge.
    pub noise: &'a [f32],
    /// Strength of the ridge.
    pub ridge: Ridge,
    /// Distance between the pixels that carry a fit.
    pub stride: usize,
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
