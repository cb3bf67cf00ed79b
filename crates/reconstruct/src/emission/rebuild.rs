//! Directly seen emission, rebuilt no further than its noise reaches.

use stack::{Cancelled, Image, Monitor};

use crate::box_filter::box_mean;
use crate::prefilter::FeatureSet;
use crate::reconstruction::Reconstruction;
use crate::regression::{RegressionInput, RegressionSettings, regress};

/// Rebuilds directly seen emission. A lamp is no spike, and where every bucket sees the same of it there is nothing to
/// rebuild. No feature tells what a lamp or background looks like, so the regression is believed only as far as it stays
/// within the noise: with variance v of the noisy value y and a fit x, the result is y + w (x − y), w = v / max(v, (x − y)²)
/// over 3×3 pixels.
pub fn rebuild_emission(
    colour: &Image,
    variance: &Image,
    features: &FeatureSet,
    settings: &RegressionSettings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, Cancelled> {
    let (size, pixels) = (colour.size(), colour.pixels());
    let noise: Vec<f32> = (0..pixels).map(|pixel| variance.mean_at(pixel)).collect();
    let noisy: Vec<bool> = noise.iter().map(|v| *v > 0.0).collect();
    let input = RegressionInput { colour, variance, features, active: Some(&noisy) };
    let mut fit = regress(&input, settings, monitor)?;
    let change = |pixel: usize| {
        let (x, y) = (fit.picture.rgb(pixel), colour.rgb(pixel));
        (0..3).map(|c| (x[c] - y[c]).powi(2)).sum::<f32>() / 3.0
    };
    let change = box_mean(&(0..pixels).map(change).collect::<Vec<_>>(), size, 1);
    let noise = box_mean(&noise, size, 1);
    for pixel in (0..pixels).filter(|pixel| noisy[*pixel]) {
        let weight = noise[pixel] / noise[pixel].max(change[pixel]);
        for (x, y) in fit.picture.channels_mut().iter_mut().zip(colour.channels()) {
            x[pixel] = y[pixel] + weight * (x[pixel] - y[pixel]);
        }
        fit.mse[pixel] = weight * fit.mse[pixel] + (1.0 - weight) * noise[pixel];
    }
    Ok(Reconstruction { mse: fit.mse, ..Reconstruction::plain(fit.picture) })
}
