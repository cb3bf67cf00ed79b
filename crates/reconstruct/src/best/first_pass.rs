//! The first regression: each half guided by the other.

use stack::{Cancelled, Image, Monitor};

use super::choice::mixtures;
use super::given::Given;
use super::halves::halves_of;
use super::settings::FitSettings;
use super::split::Layers;
use crate::box_filter::box_mean;
use crate::collaborative::{Fitted, Guides, Kernel, Ridge, collaborate, units};
use crate::patch_distance::Comparison;

/// Bandwidths of the two candidates.
const BANDWIDTHS: [f32; 2] = [0.5, 1.0];

/// The first pass, and how it mixes its candidates.
pub struct FirstPass {
    /// Both halves of the low layer.
    pub halves: [Image; 2],
    weights: [Vec<f32>; 2],
}

/// Both halves of the low layer, each rebuilt with weights from the other; of the two bandwidths the one that predicts
/// the other half better. Reports the stage `first pass`.
///
/// # Errors
/// When `monitor` cancels.
pub fn first_pass(given: &Given, settings: &FitSettings, monitor: &dyn Monitor) -> Result<FirstPass, Cancelled> {
    let candidates = candidates(&given.layers.halves, given, settings, monitor)?;
    let weights = weights(&candidates, given.layers);
    Ok(FirstPass { halves: mixtures(&candidates, &weights), weights })
}

impl FirstPass {
    /// Two other images rebuilt as the halves were. Reports the stage `first pass`.
    ///
    /// # Errors
    /// When `monitor` cancels.
    pub fn rebuild(
        &self,
        images: &[Image; 2],
        given: &Given,
        settings: &FitSettings,
        monitor: &dyn Monitor,
    ) -> Result<[Image; 2], Cancelled> {
        Ok(mixtures(&candidates(images, given, settings, monitor)?, &self.weights))
    }
}

/// Two images, the first rebuilt with weights from the second half and the second with weights from the first.
fn candidates(
    images: &[Image; 2],
    given: &Given,
    settings: &FitSettings,
    monitor: &dyn Monitor,
) -> Result<Vec<[Image; 2]>, Cancelled> {
    let Given { layers, noise, samples, features } = *given;
    let size = features.set.size;
    let colours = [0, 1].map(|half: usize| layers.halves[half].channels());
    let planes = images.each_ref().map(|image| image.channels().iter().map(Vec::as_slice).collect::<Vec<_>>());
    let fitted = Fitted {
        features: &features.set.planes,
        responses: &[&planes[0], &planes[1]],
        importance: samples,
        noise,
        ridge: Ridge { least: settings.ridge, per_noise: settings.ridge_noise },
        stride: settings.stride,
        covered: settings.covered,
    };
    let guides = Guides {
        size,
        values: &[colours[1], colours[0]],
        variances: layers.variance.channels(),
        comparison: Comparison { patch_radius: 2, epsilon: 1e-8, noise_taken_off: 1.0 },
        radius: settings.first_radius,
    };
    let kernels = BANDWIDTHS.map(|bandwidth| Kernel { bandwidth, sigma: f32::INFINITY });
    monitor.begin("first pass", units(size, settings.stride, settings.covered));
    let predicted = collaborate(&fitted, &guides, &kernels, monitor)?;
    Ok(predicted.into_iter().map(|planes| halves_of(size, planes)).collect())
}

/// Weights of the two candidates: at each pixel the one of less cross-half error over 5×5 pixels, relative to
/// luminance² + 0.01, the border between them softened over 5×5 pixels.
fn weights(candidates: &[[Image; 2]], layers: &Layers) -> [Vec<f32>; 2] {
    let size = layers.variance.size();
    let error = |halves: &[Image; 2]| {
        let relative = |pixel: usize| {
            let luminance = candidates[0][0].mean_at(pixel);
            layers.cross_error(halves, pixel) / (luminance * luminance + 1e-2)
        };
        box_mean(&(0..size.pixels()).map(relative).collect::<Vec<f32>>(), size, 2)
    };
    let [first, second] = [error(&candidates[0]), error(&candidates[1])];
    let second: Vec<f32> = first.iter().zip(&second).map(|(a, b)| if b < a { 1.0 } else { 0.0 }).collect();
    let second = box_mean(&second, size, 2);
    let first = second.iter().map(|share| 1.0 - share).collect();
    [first, second]
}

#[cfg(test)]
mod tests;
