//! Halves rebuilt with weights from each other, so that noise cannot choose its own weights.

use stack::{Cancelled, Monitor, Size};

use super::settings::FitSettings;
use crate::collaborative::{Fitted, Guides, Kernel, Ridge, collaborate, units};
use crate::patch_distance::PatchComparison;

/// Two noisy halves, and what explains them.
#[derive(Clone, Copy)]
pub struct Crossed<'a> {
    /// Width and height of every plane.
    pub size: Size,
    /// Planes that explain them.
    pub features: &'a [Vec<f32>],
    /// Planes of both halves.
    pub halves: [&'a [Vec<f32>]; 2],
    /// Variance of each plane of a half.
    pub variances: &'a [Vec<f32>],
    /// Relative variance, for the ridge.
    pub noise: &'a [f32],
    /// Factor on the weight of a residual, where there is one.
    pub importance: Option<&'a [f32]>,
}

impl Crossed<'_> {
    /// The planes of two `images`, the first fitted with weights from the second half and the second with weights from the
    /// first; in windows and with the bandwidth of the first pass. Reports `stage`.
    ///
    /// # Errors
    /// When `monitor` cancels.
    pub fn fit(
        &self,
        images: [&[Vec<f32>]; 2],
        settings: &FitSettings,
        stage: &'static str,
        monitor: &dyn Monitor,
    ) -> Result<Vec<Vec<Vec<f32>>>, Cancelled> {
        let [a, b] = self.halves;
        let responses = images.map(|planes| planes.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let fitted = Fitted {
            features: self.features,
            responses: &[&responses[0], &responses[1]],
            importance: self.importance,
            noise: self.noise,
            ridge: Ridge { least: settings.ridge, per_noise: settings.ridge_noise },
            stride: settings.stride,
            covered: settings.covered,
        };
        let guides = Guides {
            size: self.size,
            values: &[b, a],
            variances: self.variances,
            comparison: PatchComparison { patch_radius: 2, epsilon: 1e-8, noise_taken_off: 1.0 },
            radius: settings.first_radius,
        };
        let kernel = Kernel { bandwidth: settings.first_bandwidth, sigma: f32::INFINITY };
        monitor.begin(stage, units(self.size, settings.stride));
        let predicted = collaborate(&fitted, &guides, &[kernel], monitor)?;
        Ok(predicted.into_iter().flatten().collect())
    }
}
