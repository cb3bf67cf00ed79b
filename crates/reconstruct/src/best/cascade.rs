//! What the residual of a picture still holds, from fine to coarse.

use rayon::prelude::*;
use stack::{Cancelled, Component, Image, Monitor, Noise, SampleCounts};

use super::features::GuideFeatures;
use super::guided_kernel::GuidedKernel;
use super::settings::CascadeSettings;

/// Further scales over which the significance of a detail is smoothed.
const SMOOTHINGS: [usize; 3] = [1, 2, 4];

/// Adds to `picture` what the buckets of `component` agree on and it lacks: the residual of each bucket, taken apart
/// into details of growing scale; a detail d counts by (E\[d²\] − c E\[v\])/E\[d²\], v its variance between buckets and
/// c the significance; what is left at the coarsest scale counts in full. Never below zero. Reports the stage `cascade`.
///
/// # Errors
/// When `monitor` cancels.
pub fn add_significant_residual(
    picture: &mut Image,
    component: &Component,
    counts: &SampleCounts,
    features: &GuideFeatures,
    settings: &CascadeSettings,
    monitor: &dyn Monitor,
) -> Result<(), Cancelled> {
    let Noise::Buckets(buckets) = &component.radiance.noise else { return Ok(()) };
    monitor.begin("cascade", settings.levels as u64);
    let size = picture.size();
    let kernel =
        GuidedKernel::new(size, features.scaled_surfaces(std::f32::consts::FRAC_1_SQRT_2 / settings.feature_scale));
    let relative: Vec<f32> = (0..size.pixels())
        .map(|pixel| {
            let luminance = picture.mean_at(pixel);
            1.0 / (luminance * luminance + 1e-2)
        })
        .collect();
    let weights = bucket_shares(counts, size.pixels(), buckets.len());
    let mut residual = residuals(buckets, picture);
    let mut found = vec![vec![0.0; size.pixels()]; 3];
    for level in 0..settings.levels {
        if monitor.cancelled() {
            return Err(Cancelled);
        }
        let step = 1 << level;
        let coarse = kernel.smooth(&residual, step);
        let detail = Detail::of(&residual, &coarse, &weights, &relative);
        let mut power = vec![detail.square, detail.variance];
        for scale in SMOOTHINGS {
            power = kernel.smooth(&power, step * scale);
        }
        for (found, mean) in found.iter_mut().zip(&detail.mean) {
            for (i, (found, mean)) in found.iter_mut().zip(mean).enumerate() {
                let (square, variance) = (power[0][i], power[1][i]);
                *found += ((square - settings.significance * variance) / (square + 1e-20)).max(0.0) * mean;
            }
        }
        residual = coarse;
        monitor.advance(1);
    }
    for (c, (plane, found)) in picture.channels_mut().iter_mut().zip(&found).enumerate() {
        for (i, (value, found)) in plane.iter_mut().zip(found).enumerate() {
            let rest: f32 = weights.iter().enumerate().map(|(b, share)| share[i] * residual[3 * b + c][i]).sum();
            *value = (*value + found + rest).max(0.0);
        }
    }
    Ok(())
}

/// The share of each bucket in the mean of every pixel.
fn bucket_shares(counts: &SampleCounts, pixels: usize, buckets: usize) -> Vec<Vec<f32>> {
    let share = |pixel: usize, bucket: usize| {
        counts.in_group(pixel, bucket, buckets) as f32 / counts.total[pixel].max(1) as f32
    };
    (0..buckets).map(|bucket| (0..pixels).map(|pixel| share(pixel, bucket)).collect()).collect()
}

/// Buckets minus `picture`, three planes for each bucket.
fn residuals(buckets: &[Image], picture: &Image) -> Vec<Vec<f32>> {
    buckets
        .par_iter()
        .flat_map_iter(|bucket| {
            bucket.channels().iter().zip(picture.channels()).map(|(y, x)| y.iter().zip(x).map(|(y, x)| y - x).collect())
        })
        .collect()
}

/// One scale of the residual.
struct Detail {
    /// Mean over buckets, three planes.
    mean: Vec<Vec<f32>>,
    /// Its square, relative, summed over channels.
    square: Vec<f32>,
    /// Its variance, relative, summed over channels.
    variance: Vec<f32>,
}

impl Detail {
    fn of(fine: &[Vec<f32>], coarse: &[Vec<f32>], shares: &[Vec<f32>], relative: &[f32]) -> Self {
        let pixels = relative.len();
        let mut detail =
            Self { mean: vec![vec![0.0; pixels]; 3], square: vec![0.0; pixels], variance: vec![0.0; pixels] };
        for pixel in 0..pixels {
            let filled = shares.iter().filter(|share| share[pixel] > 0.0).count();
            for c in 0..3 {
                let at = |b: usize| fine[3 * b + c][pixel] - coarse[3 * b + c][pixel];
                let mean: f32 = shares.iter().enumerate().map(|(b, share)| share[pixel] * at(b)).sum();
                let spread: f32 = shares.iter().enumerate().map(|(b, s)| s[pixel] * (at(b) - mean).powi(2)).sum();
                detail.mean[c][pixel] = mean;
                detail.square[pixel] += relative[pixel] * mean * mean;
                detail.variance[pixel] += relative[pixel] * spread / filled.saturating_sub(1).max(1) as f32;
            }
        }
        detail
    }
}
