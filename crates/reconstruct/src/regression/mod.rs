//! Every pixel rebuilt by a local regression on the features.

use stack::Image;

use crate::prefilter::FeatureSet;

/// What the regression starts from.
#[derive(Clone, Copy, Debug)]
pub struct RegressionInput<'a> {
    /// Radiance freed of spikes, three channels.
    pub colour: &'a Image,
    /// Variance of its mean, three channels, finite and ≥ 0.
    pub variance: &'a Image,
    /// Prefiltered features.
    pub features: &'a FeatureSet,
    /// Pixels to rebuild; the others keep their colour with an error of zero. `None`: all.
    pub active: Option<&'a [bool]>,
}

/// What the regression finds, one value per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Regression {
    /// The estimate α̂ (eq. 4), three channels.
    pub picture: Image,
    /// Estimated mean squared error (eq. 7), mean over RGB.
    pub mse: Vec<f32>,
    /// Shared bandwidth h (eq. 14).
    pub bandwidth: Vec<f32>,
    /// Rank k of the reduced space (eq. 12).
    pub rank: Vec<f32>,
}
