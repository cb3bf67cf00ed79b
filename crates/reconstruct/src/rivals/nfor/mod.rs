//! Nonlinearly weighted first-order regression (Bitterli et al. 2016: *Nonlinearly Weighted First-order Regression for
//! Denoising Monte Carlo Renderings*).
//!
//! Features are freed of noise by non-local means, each half with weights from the other (section 5.1, `features`). Each
//! half of the colour is fitted linearly to the features around every pixel, weighted by the other half's patches, with
//! two bandwidths (section 5.2); the better of both is chosen by its error against the other half (section 5.3,
//! `selection`). A second pass filters what noise is left (section 5.4). The fits are those of `crate::collaborative`.
//!
//! Against the authors' program: weights and choices are shared by the colour channels; variances are ½ a pixel's own
//! and ½ that of 3×3 pixels, as far as that is no more than four times its own, since those of half-buffers are noisy; a faint
//! ridge stands in for their rank-revealing decomposition. Fireflies are no matter of the paper: they stay.

mod features;
mod selection;
#[cfg(test)]
mod tests;

use stack::{Cancelled, Component, FeatureStack, Image, Monitor, Noise, SampleCounts, Size};

use crate::Settings;
use crate::box_filter::box_mean;
use crate::collaborative::{Fitted, Guides, Kernel, Ridge, collaborate, units};
use crate::components::variance_of;
use crate::patch_distance::PatchComparison;
use crate::prefilter::FeatureSet;
use crate::reconstruction::{ReconstructError, Reconstruction};
use crate::recorruption::recorrupted_halves;
use features::{FeatureHalves, final_features, half_features};
use selection::{Candidate, select};

stack::knobs! {
    /// Nonlinearly weighted first-order regression (Bitterli et al. 2016).
    pub struct NforSettings("nfor") {
        /// Radius of the window, in pixels (section 5.2).
        radius: usize = 9, 1..=32;
        /// Radius of the patches that are compared, in pixels.
        patch_radius: usize = 3, 0..=8;
        /// Distance between the pixels that carry a fit; the paper has one at every pixel.
        stride: usize = 2, 1..=8;
        /// Ridge, relative to features that fill a range of 2.
        ridge: f32 = 1e-5, 1e-9..=1.0;
    }
}

/// Bandwidths that are tried (section 5.3).
const BANDWIDTHS: [f32; 2] = [0.5, 1.0];
/// Bandwidth of the second pass (section 5.4).
const FINAL_BANDWIDTH: f32 = 1.0;
/// Added to every variance of colour, so that noiseless patches have a distance.
const LEAST_VARIANCE: f32 = 1e-7;
/// Most of the variance around a pixel that counts, in units of its own. A thin bright edge is noisy where few samples are; a
/// dark pixel beside it that was thought as noisy would look like the edge, and a fit through both falls below zero. Noise that
/// was told from the picture is too rough to say which pixel it is of.
const MOST_AROUND: f32 = 4.0;

/// The colour of a component: both halves, and the variance of a half.
#[derive(Clone, Debug)]
struct ColourHalves {
    halves: [Image; 2],
    variance: Image,
}

/// Rebuilds the radiance of `component`, whose noise was `noise_measured` or told from the picture. The error map is the
/// selection's own estimate (section 5.3) of the mean of both halves before the second pass.
///
/// # Errors
/// When the noise does not come in buckets, there is no feature, or `monitor` cancels.
pub fn rebuild(
    stack: &FeatureStack,
    component: &Component,
    noise_measured: bool,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let most_around = if noise_measured { MOST_AROUND } else { f32::INFINITY };
    let halves = match &component.radiance.noise {
        Noise::VarianceOfMean(_) => {
            recorrupted_halves(&component.radiance.mean, &variance_of(component, &stack.samples)?)
        }
        _ => {
            let halves = component.radiance.halves(&stack.samples);
            let halves = halves.ok_or(ReconstructError::NoBuckets { layer: component.role.layer() })?;
            whole_halves(halves, &component.radiance.mean, &stack.samples)
        }
    };
    let colour =
        ColourHalves { halves, variance: variance_of_half(variance_of(component, &stack.samples)?, most_around) };
    let features = half_features(stack, monitor)?;
    let (picture, mse) = denoised(&colour, &features, &settings.nfor, monitor)?;
    Ok(Reconstruction { mse, ..Reconstruction::plain(picture) })
}

/// Both passes over the regression: the picture and its estimated mean squared error.
fn denoised(
    colour: &ColourHalves,
    features: &FeatureHalves,
    settings: &NforSettings,
    monitor: &dyn Monitor,
) -> Result<(Image, Vec<f32>), Cancelled> {
    let candidates = first_pass(colour, features, settings, monitor)?;
    let selected = select(&candidates, colour, monitor)?;
    let (mean, spread) = combined(&selected.halves);
    let set = final_features(features, monitor)?;
    monitor.begin("second pass", units(mean.size(), settings.stride));
    let picture =
        regression(&set, &mean, (&mean, &spread), &[FINAL_BANDWIDTH], settings, monitor)?.pop().unwrap_or(mean);
    Ok((without_negative_values(picture), selected.mse))
}

/// Section 5.2: both halves with every bandwidth, each with weights and features from the other half.
fn first_pass(
    colour: &ColourHalves,
    features: &FeatureHalves,
    settings: &NforSettings,
    monitor: &dyn Monitor,
) -> Result<Vec<Candidate>, Cancelled> {
    let ColourHalves { halves: [a, b], variance } = colour;
    monitor.begin("first pass", 2 * units(a.size(), settings.stride));
    let of_a = regression(&features.filtered[1], a, (b, variance), &BANDWIDTHS, settings, monitor)?;
    let of_b = regression(&features.filtered[0], b, (a, variance), &BANDWIDTHS, settings, monitor)?;
    Ok(of_a.into_iter().zip(of_b).map(|(a, b)| Candidate { halves: [a, b] }).collect())
}

/// Collaborative fits of the `fitted` colour to `set`, once per bandwidth, weighted by the patches of a guide: its values
/// and their variance.
fn regression(
    set: &FeatureSet,
    fitted: &Image,
    (values, variances): (&Image, &Image),
    bandwidths: &[f32],
    settings: &NforSettings,
    monitor: &dyn Monitor,
) -> Result<Vec<Image>, Cancelled> {
    let size = set.size;
    let planes: Vec<&[f32]> = fitted.channels().iter().map(Vec::as_slice).collect();
    let fitted = Fitted {
        features: &set.planes,
        responses: &[&planes],
        importance: None,
        noise: &vec![0.0; size.pixels()],
        ridge: Ridge { least: settings.ridge, per_noise: 0.0 },
        stride: settings.stride,
        covered: 1.0,
    };
    let guides = Guides {
        size,
        values: &[values.channels()],
        variances: variances.channels(),
        comparison: comparison(settings.patch_radius),
        radius: settings.radius,
    };
    let kernels: Vec<Kernel> =
        bandwidths.iter().map(|bandwidth| Kernel { bandwidth: *bandwidth, sigma: f32::INFINITY }).collect();
    let predicted = collaborate(&fitted, &guides, &kernels, monitor)?;
    Ok(predicted.into_iter().map(|planes| Image::from_channels(size, planes.into_iter().flatten().collect())).collect())
}

/// Patches as Rousselle et al. 2012 compare them.
fn comparison(patch_radius: usize) -> PatchComparison {
    PatchComparison { patch_radius, epsilon: 1e-7, noise_taken_off: 1.0 }
}

/// Mean of two halves, and its variance as their difference tells it.
fn combined(halves: &[Image; 2]) -> (Image, Image) {
    let merge = |value: &dyn Fn(f32, f32) -> f32| {
        let channels = halves[0].channels().iter().zip(halves[1].channels());
        let merged = channels.map(|(a, b)| a.iter().zip(b).map(|(a, b)| value(*a, *b)).collect());
        Image::from_channels(halves[0].size(), merged.collect())
    };
    (merge(&|a, b| 0.5 * (a + b)), merge(&|a, b| 0.25 * (a - b) * (a - b) + LEAST_VARIANCE))
}

fn without_negative_values(mut image: Image) -> Image {
    image.channels_mut().iter_mut().flatten().for_each(|v| *v = v.max(0.0));
    image
}

/// Halves without gaps: one without samples has the mean of all instead.
fn whole_halves(mut halves: [Image; 2], mean: &Image, counts: &SampleCounts) -> [Image; 2] {
    for (half, image) in halves.iter_mut().enumerate() {
        for pixel in (0..mean.pixels()).filter(|pixel| counts.in_group(*pixel, half, 2) == 0) {
            for (values, means) in image.channels_mut().iter_mut().zip(mean.channels()) {
                values[pixel] = means[pixel];
            }
        }
    }
    halves
}

/// Variance of a half from that of the whole, ½ its own and ½ that of the 3×3 pixels around it, up to `most_around` of its own.
fn variance_of_half(mut variance: Image, most_around: f32) -> Image {
    let size: Size = variance.size();
    for plane in variance.channels_mut() {
        let smooth = box_mean(plane, size, 1);
        plane.iter_mut().zip(&smooth).for_each(|(v, smooth)| *v += smooth.min(most_around * *v) + LEAST_VARIANCE);
    }
    variance
}
