//! What the residual of a picture still holds, from fine to coarse.

use rayon::prelude::*;
use stack::{Cancelled, Image, Monitor, SampleCounts};

use super::guided_kernel::GuidedKernel;
use super::settings::CascadeSettings;

/// Further scales over which the significance of a detail is smoothed.
const SMOOTHINGS: [usize; 3] = [1, 2, 4];

/// Independent parts of a picture.
pub struct Parts {
    images: Vec<Image>,
    /// The share of each in the mean of every pixel.
    shares: Vec<Vec<f32>>,
}

impl Parts {
    /// `images` as they come from [`stack::Estimate::groups`].
    pub fn new(images: Vec<Image>, counts: &SampleCounts) -> Self {
        let pixels = images.first().map_or(0, Image::pixels);
        let shares = group_shares(counts, pixels, images.len());
        Self { images, shares }
    }

    /// Two images whose sum is the picture.
    pub fn adding_up(mut images: [Image; 2]) -> Self {
        images.iter_mut().flat_map(Image::channels_mut).flatten().for_each(|v| *v *= 2.0);
        Self::halves(images)
    }

    /// Two images whose mean is the picture.
    pub fn halves(images: [Image; 2]) -> Self {
        let shares = vec![vec![0.5; images[0].pixels()]; 2];
        Self { images: images.to_vec(), shares }
    }
}

/// Adds to `picture` what `parts` agree on and it lacks: the residual of each part, taken apart by `kernel` into
/// details of growing scale. A detail d counts by (E\[d²\] − c E\[v\])/E\[d²\], v its variance between parts and c the
/// significance; squares are relative to `brightness`; what is left at the coarsest scale counts in full. Never below zero. Reports the stage `cascade`.
///
/// # Errors
/// When `monitor` cancels.
pub fn add_significant_residual(
    picture: &mut Image,
    parts: Parts,
    brightness: &Image,
    kernel: &GuidedKernel,
    settings: &CascadeSettings,
    monitor: &dyn Monitor,
) -> Result<(), Cancelled> {
    monitor.begin("cascade", settings.levels as u64);
    let relative: Vec<f32> = (0..picture.pixels())
        .map(|pixel| {
            let luminance = brightness.mean_at(pixel);
            1.0 / (luminance * luminance + 1e-2)
        })
        .collect();
    let shares = parts.shares;
    let mut residual = residuals(parts.images, picture);
    let mut found = vec![vec![0.0; picture.pixels()]; 3];
    for level in 0..settings.levels {
        if monitor.cancelled() {
            return Err(Cancelled);
        }
        let step = 1 << level;
        let coarse = kernel.smooth(&residual, step);
        let detail = Detail::of(&residual, &coarse, &shares, &relative);
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
            let rest: f32 = shares.iter().enumerate().map(|(g, share)| share[i] * residual[3 * g + c][i]).sum();
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
