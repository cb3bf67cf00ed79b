//! The noise of a picture of which only the mean is known.

use rayon::prelude::*;
use stack::{FeatureRole, FeatureStack, Image};

use super::CompletionSettings;
use super::local_fit::LocalFit;
use super::place::has_depth;
use super::roughness::roughness_of_light;
use crate::box_filter::box_mean;
use crate::collaborative::offsets;
use crate::eight::{LANES, Lanes};
use crate::lone_light::share_like_neighbours;
use crate::per_pixel::{ByEight, Pixels, planes_by_eight};
use crate::prefilter::{PrefilterError, VarianceSource, normalised, regressors};

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
    let squares = planes_by_eight(size.pixels(), &SquaredResiduals { fit, light: &low });
    let squares = Image::from_channels(size, squares.into());
    let mut variance = without_detail(squares, &low, limit);
    variance.add(&with_shares(mean, &kept, |y, kept| (y * (1.0 - kept)).powi(2)));
    Ok(variance)
}

/// `change` of every value and its pixel's share.
fn with_shares(image: &Image, shares: &[f32], change: impl Fn(f32, f32) -> f32 + Sync) -> Image {
    let changed = |plane: &Vec<f32>| plane.iter().zip(shares).map(|(y, share)| change(*y, *share)).collect();
    Image::from_channels(image.size(), image.channels().par_iter().map(changed).collect())
}

/// `squares` of residuals, less where `light` is smoother along some line than the fit says: there are edges or textures
/// that no feature explains. Over 3×3 pixels, relative to brightness, they do not exceed `factor` times its roughness.
fn without_detail(mut squares: Image, light: &Image, factor: f32) -> Image {
    let (size, rough) = (light.size(), roughness_of_light(light));
    let limits = rough.variance.channels().par_iter().zip(rough.scale.channels());
    squares.channels_mut().par_iter_mut().zip(limits).for_each(|(plane, (variance, scale))| {
        let relative: Vec<f32> = plane.iter().zip(scale).map(|(square, scale)| square / scale).collect();
        let around = box_mean(&relative, size, 1);
        for (i, square) in plane.iter_mut().enumerate() {
            let (limit, around) = (factor * variance[i], around[i] * scale[i]);
            if limit < around {
                *square *= limit / around;
            }
        }
    });
    squares
}

/// Whether there is a feature that may explain detail: more than places on the screen.
fn is_explained(stack: &FeatureStack) -> bool {
    stack.features.iter().any(|feature| feature.role != FeatureRole::Position) || has_depth(stack)
}

/// The features, each of which fills a range of 1, not filtered: their noise is unknown, too.
fn feature_planes(stack: &FeatureStack) -> Result<Vec<Vec<f32>>, PrefilterError> {
    let halved = |feature| {
        let mut planes = normalised(feature, &stack.samples, VarianceSource::Buckets).planes;
        planes.iter_mut().flatten().for_each(|v| *v *= 0.5);
        planes
    };
    let planes: Vec<Vec<Vec<f32>>> = regressors(stack)?.into_par_iter().map(halved).collect();
    Ok(planes.into_iter().flatten().collect())
}

/// What fits leave of `light`, squared, in units of what they would leave of white noise.
struct SquaredResiduals<'a> {
    fit: LocalFit<'a>,
    light: &'a Image,
}

impl ByEight<3> for SquaredResiduals<'_> {
    #[inline(always)]
    fn numbers(&self, pixels: Pixels) -> [Lanes; 3] {
        let mut residuals = [[0.0; LANES]; 3];
        let mut norm = [0.0; LANES];
        for (offset, kernel) in offsets(self.fit.radius).zip(self.fit.equivalent_kernels(pixels)) {
            let own = if offset == [0, 0] { 1.0 } else { 0.0 };
            let mut left = [0.0; LANES];
            for lane in 0..LANES {
                left[lane] = own - kernel[lane];
                norm[lane] += left[lane] * left[lane];
            }
            for (residual, plane) in residuals.iter_mut().zip(self.light.channels()) {
                let light = pixels.moved(plane, self.fit.size, offset);
                for lane in 0..LANES {
                    residual[lane] += left[lane] * light[lane];
                }
            }
        }
        for residual in &mut residuals {
            for lane in 0..LANES {
                // Half a value's own variance at least must show, or rounding and chance decide.
                residual[lane] = residual[lane] * residual[lane] / norm[lane].max(0.05);
            }
        }
        residuals
    }
}
