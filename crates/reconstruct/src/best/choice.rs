//! Candidates mixed by how well each predicts the half it was not made from.

use stack::Image;

use super::guided_kernel::GuidedKernel;
use super::settings::ChoiceSettings;
use super::split::Layers;
use crate::box_filter::box_mean;

/// Least error that the softness is relative to.
const LEAST_ERROR: f32 = 1e-5;

/// Both halves of the mixture of `candidates` (both halves of each), whose errors `kernel` smooths.
pub fn choose(
    candidates: &[[Image; 2]],
    layers: &Layers,
    kernel: &GuidedKernel,
    settings: &ChoiceSettings,
) -> [Image; 2] {
    let size = layers.variance.size();
    let precision = precisions(candidates, layers, settings);
    let errors: Vec<Vec<f32>> = candidates.iter().map(|halves| cross_errors(halves, layers, &precision)).collect();
    let errors = kernel.smooth(&kernel.smooth(&errors, 1), 2);
    let weights: Vec<Vec<f32>> =
        soft_minimum(&errors, settings.softness).iter().map(|plane| box_mean(plane, size, 2)).collect();
    [0, 1].map(|half: usize| mixture(candidates, &weights, half))
}

/// What a squared error counts at each pixel: n/(1 + 3 n v), n = 1/(luminance² + 0.01) with the mean luminance of all
/// candidates, v the variance of a half.
fn precisions(candidates: &[[Image; 2]], layers: &Layers, settings: &ChoiceSettings) -> Vec<f32> {
    let images: Vec<&Image> = candidates.iter().flatten().collect();
    let precision = |pixel: usize| {
        let luminance = images.iter().map(|image| image.mean_at(pixel)).sum::<f32>() / images.len() as f32;
        let relative = 1.0 / (luminance * luminance + 1e-2);
        relative / (1.0 + settings.precision * relative * layers.variance.mean_at(pixel))
    };
    (0..layers.variance.pixels()).map(precision).collect()
}

/// Cross-half error of every pixel, times `precision`.
fn cross_errors(halves: &[Image; 2], layers: &Layers, precision: &[f32]) -> Vec<f32> {
    precision.iter().enumerate().map(|(pixel, precision)| layers.cross_error(halves, pixel) * precision).collect()
}

/// Weights that fall with the error relative to the least one; they add up to 1 at every pixel.
fn soft_minimum(errors: &[Vec<f32>], softness: f32) -> Vec<Vec<f32>> {
    let mut weights = vec![vec![0.0; errors[0].len()]; errors.len()];
    for pixel in 0..errors[0].len() {
        let least = errors.iter().map(|plane| plane[pixel]).fold(f32::INFINITY, f32::min);
        let scale = softness * least.max(LEAST_ERROR);
        let weight = |plane: &Vec<f32>| (-(plane[pixel] - least) / scale).exp();
        let total: f32 = errors.iter().map(weight).sum();
        for (to, plane) in weights.iter_mut().zip(errors) {
            to[pixel] = weight(plane) / total;
        }
    }
    weights
}

/// One half of all `candidates`, added up with their `weights`.
pub fn mixture(candidates: &[[Image; 2]], weights: &[Vec<f32>], half: usize) -> Image {
    let mut mixed = Image::zeros(candidates[0][half].size(), 3);
    for (candidate, weights) in candidates.iter().zip(weights) {
        for (sum, plane) in mixed.channels_mut().iter_mut().zip(candidate[half].channels()) {
            for ((sum, value), weight) in sum.iter_mut().zip(plane).zip(weights) {
                *sum += weight * value;
            }
        }
    }
    mixed
}

#[cfg(test)]
mod tests;
