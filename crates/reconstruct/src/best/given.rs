//! What both regressions rest on.

use super::features::GuideFeatures;
use super::split::Layers;

/// What both regressions rest on.
#[derive(Clone, Copy)]
pub struct Given<'a> {
    /// The low layer and the events.
    pub layers: &'a Layers,
    /// Relative noise ν.
    pub noise: &'a [f32],
    /// Samples of every pixel over their mean, where that counts.
    pub samples: Option<&'a [f32]>,
    /// Prefiltered features.
    pub features: &'a GuideFeatures,
}
