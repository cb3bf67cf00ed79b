//! The picture's own estimate of its squared error.

use stack::Image;

use super::guided_kernel::GuidedKernel;
use super::luminance;
use super::settings::ErrorSettings;
use crate::box_filter::box_mean;

/// Dilations of the kernel, one after the other.
const DILATIONS: [usize; 2] = [1, 2];

/// Estimated squared error of `picture`, the mean of the `halves` plus spread events of the given variance; mean over RGB.
///
/// Two terms, each smoothed by `kernel` relative to the squared luminance around it, so that bright pixels do not lend
/// their error to dark ones: a multiple of (A − B)²/4 between the halves, which is the variance of their mean, and a
/// multiple of the events' variance. The multiples stand for what the halves share, weights and bias.
pub fn estimated_error(
    halves: &[Image; 2],
    events: &[f32],
    picture: &Image,
    kernel: &GuidedKernel,
    settings: &ErrorSettings,
) -> Vec<f32> {
    let scale: Vec<f32> = box_mean(&luminance(picture), picture.size(), 1).iter().map(|l| l * l + 1e-3).collect();
    let between = variance_of_mean(halves);
    let relative = |pixel: usize| (settings.halves * between[pixel] + settings.events * events[pixel]) / scale[pixel];
    let mut error = vec![(0..scale.len()).map(relative).collect::<Vec<f32>>()];
    for dilation in DILATIONS {
        error = kernel.smooth(&error, dilation);
    }
    error.swap_remove(0).iter().zip(&scale).map(|(error, scale)| error * scale).collect()
}

/// (A − B)²/4, mean over RGB.
fn variance_of_mean([a, b]: &[Image; 2]) -> Vec<f32> {
    let square = |pixel: usize| {
        let (a, b) = (a.rgb(pixel), b.rgb(pixel));
        (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>() / 12.0
    };
    (0..a.pixels()).map(square).collect()
}

/// Gives pixels that saw no noise in directly seen light that of the 3×3 pixels around them: beside the edge of a lamp
/// a pixel that no sample hit is as uncertain as one that was. Keeps the mean of `mse`.
pub fn share_unseen(mse: &mut [f32], variance: &Image) {
    let noise = luminance(variance);
    let around = box_mean(&noise, variance.size(), 1);
    for (pixel, mse) in mse.iter_mut().enumerate() {
        if noise[pixel] == 0.0 {
            *mse += around[pixel];
        }
    }
}
