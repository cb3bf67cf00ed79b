//! The second regression, guided by a pilot picture.

use rayon::prelude::*;
use stack::{Cancelled, Image, Monitor};

use super::given::Given;
use super::halves::{halves_of, luminance};
use super::settings::FitSettings;
use crate::box_filter::box_mean_twice;
use crate::collaborative::{Fitted, Guides, Kernel, Ridge, collaborate, units};
use crate::patch_distance::PatchComparison;
use crate::per_pixel::plane;

/// Bandwidths of the candidates that are as wide as their window; where only a few are made, all but the last.
const BANDWIDTHS: [f32; 3] = [0.7, 1.5, 3.0];

/// Bandwidth of the candidate with a small window.
const SMALL_BANDWIDTH: f32 = 1.5;

/// Bandwidth of the candidate with a tiny window: what is left of an edge that no feature and no pilot shows is found by
/// hardly more than the pixel's neighbours.
const TINY_BANDWIDTH: f32 = 3.0;

/// Radius of the patches that are compared.
const PATCH_RADIUS: usize = 1;

/// Radius of the windows that tolerated differences are smoothed over, twice.
const TOLERANCE_RADIUS: usize = 2;

/// Deviations after which a Gaussian is negligible: its weight is below 10⁻⁴.
const REACH: f32 = 4.3;

/// How far from a pixel the second pass looks, in rows: fits that predict it lie as far as a window reaches, and so do
/// those that decide whether one of them is needed; patches reach farther, and tolerances are smoothed.
pub fn reach(settings: &FitSettings) -> usize {
    2 * settings.second_radius + PATCH_RADIUS + 2 * TOLERANCE_RADIUS
}

/// The candidates of the second pass: two images (the halves of the low layer) rebuilt with the same weights, for three
/// bandwidths, a small window and a tiny one, or for two bandwidths and a tiny window; `pilot` guides them, `first` are
/// the halves of the first pass. Reports the stage `second pass`.
///
/// # Errors
/// When `monitor` cancels.
pub fn second_pass(
    images: &[Image; 2],
    given: &Given,
    pilot: &Image,
    first: &[Image; 2],
    settings: &FitSettings,
    monitor: &dyn Monitor,
) -> Result<Vec<[Image; 2]>, Cancelled> {
    let Given { noise, samples, features, .. } = given;
    let size = features.set.size;
    let planes: Vec<&[f32]> = images.iter().flat_map(|half| half.channels()).map(Vec::as_slice).collect();
    let scale = tolerated(pilot, first, settings.tolerance);
    let importance = importance(pilot, samples.as_deref(), settings.relative);
    let guides = Guides {
        size,
        values: &[pilot.channels()],
        variances: &scale,
        comparison: PatchComparison { patch_radius: PATCH_RADIUS, epsilon: 1e-8, noise_taken_off: 0.0 },
        radius: settings.second_radius,
    };
    let fitted = Fitted {
        features: &features.set.planes,
        responses: &[&planes],
        importance: Some(&importance),
        noise,
        ridge: Ridge { least: settings.ridge, per_noise: settings.ridge_noise },
        stride: settings.stride,
        covered: settings.covered,
    };
    let mut kernels = BANDWIDTHS.map(|bandwidth| Kernel { bandwidth, sigma: f32::INFINITY }).to_vec();
    if settings.few {
        kernels.pop();
    } else {
        kernels.push(Kernel { bandwidth: SMALL_BANDWIDTH, sigma: settings.small_sigma });
    }
    let tiny = Kernel { bandwidth: TINY_BANDWIDTH, sigma: settings.tiny_sigma };
    let radius = settings.second_radius.min((REACH * tiny.sigma).ceil() as usize);
    // By itself where its window is smaller: the lattice leaves many pixels to fits of their own, which need not be as
    // wide.
    let apart = radius < guides.radius;
    kernels.extend((!apart).then_some(tiny));
    monitor.begin("second pass", (1 + u64::from(apart)) * units(size, settings.stride));
    let mut predicted = collaborate(&fitted, &guides, &kernels, monitor)?;
    if apart {
        predicted.extend(collaborate(&fitted, &Guides { radius, ..guides }, &[tiny], monitor)?);
    }
    Ok(predicted.into_iter().map(|planes| halves_of(size, planes)).collect())
}

/// What a residual counts: 1/(m² + 0.001) with the luminance m of the `pilot` when `relative`, times the pixel's share of
/// samples.
fn importance(pilot: &Image, samples: Option<&[f32]>, relative: bool) -> Vec<f32> {
    let of_brightness = |m: f32| if relative { 1.0 / (m * m + 1e-3) } else { 1.0 };
    plane(pilot.pixels(), |pixel| of_brightness(pilot.mean_at(pixel)) * samples.map_or(1.0, |samples| samples[pixel]))
}

/// τ, the squared difference in the pilot that is tolerated: (A − B)²/4 of the first pass smoothed twice over 5×5
/// pixels, and `tolerance` · (L² + 0.001), L the pilot's luminance.
fn tolerated(pilot: &Image, first: &[Image; 2], tolerance: f32) -> Vec<Vec<f32>> {
    let size = pilot.size();
    let pilot = luminance(pilot);
    let [a, b] = [0, 1].map(|half: usize| first[half].channels());
    a.iter()
        .zip(b)
        .map(|(a, b)| {
            let spread = plane(size.pixels(), |pixel| 0.25 * (a[pixel] - b[pixel]) * (a[pixel] - b[pixel]));
            let mut smooth = box_mean_twice(&spread, size, TOLERANCE_RADIUS);
            smooth.par_iter_mut().zip(&pilot).for_each(|(s, m)| *s += tolerance * (m * m + 1e-3));
            smooth
        })
        .collect()
}

#[cfg(test)]
mod tests;
