//! The first regression: each half guided by the other.

use stack::{Cancelled, Image, Monitor};

use super::given::Given;
use super::settings::FitSettings;
use super::split::Layers;
use crate::box_filter::box_mean;
use crate::collaborative::{Fitted, Guide, Kernel, Ridge, collaborate, rows_of, units};
use crate::patch_distance::{Comparison, NoisyPlanes};

/// Bandwidths of the two candidates.
const BANDWIDTHS: [f32; 2] = [0.5, 1.0];

/// Both halves of the low layer, each rebuilt with weights from the other; of the two bandwidths the one that predicts
/// the other half better. Reports the stage `first pass`.
///
/// # Errors
/// When `monitor` cancels.
pub fn first_pass(given: &Given, settings: &FitSettings, monitor: &dyn Monitor) -> Result<[Image; 2], Cancelled> {
    let Given { layers, noise, samples, features } = *given;
    let size = features.set.size;
    let rows = rows_of(&features.set, [&layers.halves[0], &layers.halves[1]]);
    let ridge = Ridge { least: settings.ridge, per_noise: settings.ridge_noise };
    let fitted = Fitted { rows: &rows, importance: samples, noise, ridge, stride: settings.stride };
    let kernels = BANDWIDTHS.map(|bandwidth| Kernel { bandwidth, sigma: f32::INFINITY });
    monitor.begin("first pass", 2 * units(size, settings.stride));
    let mut candidates: [Vec<Image>; 2] = Default::default();
    for (half, rebuilt) in candidates.iter_mut().enumerate() {
        let guide = Guide {
            planes: NoisyPlanes {
                size,
                values: layers.halves[1 - half].channels(),
                variances: layers.variance.channels(),
            },
            comparison: Comparison { patch_radius: 2, epsilon: 1e-8, noise_taken_off: 1.0 },
            radius: settings.first_radius,
        };
        let predicted = collaborate(&fitted, &guide, &kernels, monitor)?;
        *rebuilt = predicted.into_iter().map(|[a, b]| if half == 0 { a } else { b }).collect();
    }
    Ok(better_of(&candidates, layers))
}

/// Mixes two candidates, given as `[half][candidate]`: at each pixel the one of less cross-half error over 5×5 pixels,
/// the border between them softened over 5×5 pixels.
fn better_of(candidates: &[Vec<Image>; 2], layers: &Layers) -> [Image; 2] {
    let size = layers.variance.size();
    let errors = [0, 1].map(|candidate| box_mean(&cross_error(candidates, candidate, layers), size, 2));
    let second: Vec<f32> = errors[0].iter().zip(&errors[1]).map(|(a, b)| if b < a { 1.0 } else { 0.0 }).collect();
    let second = box_mean(&second, size, 2);
    [0, 1].map(|half: usize| {
        let [a, b] = [0, 1].map(|candidate: usize| candidates[half][candidate].channels());
        let mix = |(a, b): (&Vec<f32>, &Vec<f32>)| {
            a.iter().zip(b).zip(&second).map(|((a, b), share)| (1.0 - share) * a + share * b).collect()
        };
        Image::from_channels(size, a.iter().zip(b).map(mix).collect())
    })
}

/// Σ over halves and channels of (x − y)² − v, x one half's candidate and y the other's noisy value, relative to
/// luminance² + 0.01.
fn cross_error(candidates: &[Vec<Image>; 2], candidate: usize, layers: &Layers) -> Vec<f32> {
    let error = |pixel: usize| {
        let v = layers.variance.rgb(pixel);
        let mut sum = 0.0;
        for half in 0..2 {
            let (x, y) = (candidates[half][candidate].rgb(pixel), layers.halves[1 - half].rgb(pixel));
            sum += (0..3).map(|c| (x[c] - y[c]).powi(2) - v[c]).sum::<f32>();
        }
        let luminance = candidates[0][0].mean_at(pixel);
        sum / (luminance * luminance + 1e-2)
    };
    (0..layers.variance.pixels()).map(error).collect()
}

#[cfg(test)]
mod tests;
