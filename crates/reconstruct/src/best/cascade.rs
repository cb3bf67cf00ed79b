//! What the residual of a picture still holds, from fine to coarse.

use rayon::prelude::*;
use stack::{Cancelled, Component, Image, Monitor, SampleCounts};

use super::features::GuideFeatures;
use super::guided_kernel::GuidedKernel;
use super::settings::CascadeSettings;

/// Further scales over which the significance of a detail is smoothed.
const SMOOTHINGS: [usize; 3] = [1, 2, 4];

/// Groups that buckets are put together in: fewer are less work and say less about the variance.
const GROUPS: usize = 4;

/// Adds to `picture` what the buckets of `component` agree on and it lacks: the residual of each group of
/// buckets, taken apart
/// into details of growing scale; a detail d counts by (E\[d²\] − c E\[v\])/E\[d²\], v its variance between groups and
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
    let Some(groups) = component.radiance.groups(counts, GROUPS) else { return Ok(()) };
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
    let weights = group_shares(counts, size.pixels(), groups.len());
    let mut residual = residuals(groups, picture);
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

/// The share of each group in the mean of every pixel.
fn group_shares(counts: &SampleCounts, pixels: usize, groups: usize) -> Vec<Vec<f32>> {
    let share =
        |pixel: usize, group: usize| counts.in_group(pixel, group, groups) as f32 / counts.total[pixel].max(1) as f32;
    (0..groups).into_par_iter().map(|group| (0..pixels).map(|pixel| share(pixel, group)).collect()).collect()
}

/// Groups minus `picture`, three planes for each group.
fn residuals(mut groups: Vec<Image>, picture: &Image) -> Vec<Vec<f32>> {
    for group in &mut groups {
        for (y, x) in group.channels_mut().iter_mut().zip(picture.channels()) {
            y.iter_mut().zip(x).for_each(|(y, x)| *y -= x);
        }
    }
    groups.into_iter().flat_map(Image::into_channels).collect()
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
        let pixel = |pixel: usize| {
            let filled = shares.iter().filter(|share| share[pixel] > 0.0).count();
            let scale = relative[pixel] / filled.saturating_sub(1).max(1) as f32;
            let (mut means, mut square, mut variance) = ([0.0; 3], 0.0, 0.0);
            for (c, mean) in means.iter_mut().enumerate() {
                let at = |g: usize| fine[3 * g + c][pixel] - coarse[3 * g + c][pixel];
                *mean = shares.iter().enumerate().map(|(g, share)| share[pixel] * at(g)).sum();
                square += relative[pixel] * *mean * *mean;
                let spread = |(g, share): (usize, &Vec<f32>)| share[pixel] * (at(g) - *mean).powi(2);
                variance += scale * shares.iter().enumerate().map(spread).sum::<f32>();
            }
            (means, square, variance)
        };
        let pixels: Vec<([f32; 3], f32, f32)> = (0..relative.len()).into_par_iter().map(pixel).collect();
        Self {
            mean: (0..3).map(|c| pixels.iter().map(|(mean, ..)| mean[c]).collect()).collect(),
            square: pixels.iter().map(|(_, square, _)| *square).collect(),
            variance: pixels.iter().map(|(.., variance)| *variance).collect(),
        }
    }
}

#[cfg(test)]
mod tests;
