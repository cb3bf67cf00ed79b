//! The noise of a picture of which only the mean is known.

use rayon::prelude::*;
use stack::{FeatureRole, FeatureStack, Image};

use super::CompletionSettings;
use super::local_fit::LocalFit;
use super::place::has_depth;
use super::roughness::roughness_of_light;
use crate::box_filter::box_mean;
use crate::lone_light::share_like_neighbours;
use crate::prefilter::{PrefilterError, VarianceSource, guides, normalised};

/// Variance of every value of `mean`, measured: what a linear fit to place and features around it leaves of it, squared.
///
/// A fit with the equivalent kernel l leaves r = Σ (δ − l) y, whose variance is that of a value times (1 − l₀)² + Σ l² over
/// the others, where the noise around is alike. Divided by that, r² is the variance on average, wherever the fit follows
/// the truth; detail that no feature explains counts as noise. Light that sticks out of its neighbours is left out of all
/// fits, for it would make them noisy, too; its own square is added where it is.
///
/// # Errors
/// When a feature does not fit its role or the stack.
pub fn measured_variance(
    mean: &Image,
    stack: &FeatureStack,
    settings: &CompletionSettings,
) -> Result<Image, PrefilterError> {
    let planes = feature_planes(stack)?;
    let size = stack.size();
    let limit = if is_explained(stack) { settings.noise_roughness } else { settings.colour_roughness };
    let kept = share_like_neighbours(mean);
    let low = with_shares(mean, &kept, |y, kept| y * kept);
    let CompletionSettings { noise_radius: radius, noise_likeness: likeness, noise_ridge: ridge, .. } = *settings;
    let fit = LocalFit { size, planes: &planes, radius, likeness, ridge };
    let squares: Vec<[f32; 3]> = (0..size.pixels())
        .into_par_iter()
        .map_init(Vec::new, |kernel, pixel| squared_residual(&fit, &low, pixel, kernel))
        .collect();
    let squares = Image::from_channels(size, (0..3).map(|c| squares.iter().map(|s| s[c]).collect()).collect());
    let mut variance = without_detail(squares, &low, limit);
    variance.add(&with_shares(mean, &kept, |y, kept| (y * (1.0 - kept)).powi(2)));
    Ok(variance)
}

/// `change` of every value and its pixel's share.
fn with_shares(image: &Image, shares: &[f32], change: impl Fn(f32, f32) -> f32) -> Image {
    let planes = image.channels().iter();
    let planes = planes.map(|plane| plane.iter().zip(shares).map(|(y, share)| change(*y, *share)).collect());
    Image::from_channels(image.size(), planes.collect())
}

/// `squares` of residuals, less where `light` is smoother along some line than the fit says: there are edges or textures
/// that no feature explains. Over 3×3 pixels, relative to brightness, they do not exceed `factor` times its roughness.
fn without_detail(mut squares: Image, light: &Image, factor: f32) -> Image {
    let (size, rough) = (light.size(), roughness_of_light(light));
    let limits = rough.variance.channels().iter().zip(rough.scale.channels());
    for (plane, (variance, scale)) in squares.channels_mut().iter_mut().zip(limits) {
        let relative: Vec<f32> = plane.iter().zip(scale).map(|(square, scale)| square / scale).collect();
        let around = box_mean(&relative, size, 1);
        for (i, square) in plane.iter_mut().enumerate() {
            let (limit, around) = (factor * variance[i], around[i] * scale[i]);
            if limit < around {
                *square *= limit / around;
            }
        }
    }
    squares
}

/// Whether there is a feature that may explain detail: more than places on the screen.
fn is_explained(stack: &FeatureStack) -> bool {
    stack.features.iter().any(|feature| feature.role != FeatureRole::Position) || has_depth(stack)
}

/// The features on natural scales, not filtered: their noise is unknown, too.
fn feature_planes(stack: &FeatureStack) -> Result<Vec<Vec<f32>>, PrefilterError> {
    let normal = guides(stack)?.into_iter().map(|feature| normalised(feature, &stack.samples, VarianceSource::Buckets));
    Ok(normal.flat_map(|feature| feature.planes).map(|plane| plane.iter().map(|v| 0.5 * v).collect()).collect())
}

fn squared_residual(fit: &LocalFit, mean: &Image, pixel: usize, kernel: &mut Vec<(usize, f32)>) -> [f32; 3] {
    fit.equivalent_kernel(pixel, kernel);
    let (mut residual, mut norm) = ([0.0; 3], 0.0);
    for (near, weight) in kernel.iter() {
        let left = if *near == pixel { 1.0 - weight } else { -weight };
        norm += left * left;
        residual.iter_mut().zip(mean.rgb(*near)).for_each(|(sum, y)| *sum += left * y);
    }
    // Half a value's own variance at least must show, or rounding and chance decide.
    residual.map(|r| r * r / norm.max(0.05))
}
