//! What the residual of a picture still holds, from fine to coarse.

use rayon::prelude::*;
use stack::{Cancelled, Image, Monitor, SampleCounts};

use super::guided_kernel::GuidedKernel;
use super::settings::CascadeSettings;
use crate::per_pixel;

/// How often the significance of a detail is smoothed: at its own scale, and at so many less one of the next.
const SMOOTHINGS: usize = 3;

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
    let mut pending: Vec<Pending> = Vec::new();
    // A detail is smoothed at its own scale and along with the residual at the next two.
    for level in 0..settings.levels + SMOOTHINGS - 1 {
        if monitor.cancelled() {
            return Err(Cancelled);
        }
        let (step, last) = (1 << level, level >= settings.levels);
        let kept = if last { 0 } else { residual.len() };
        let powers = pending.iter().flat_map(|pending| &pending.power);
        let planes: Vec<&Vec<f32>> = residual[..kept].iter().chain(powers).collect();
        let mut smooth = kernel.smooth(&planes, step).into_iter();
        let coarse: Vec<Vec<f32>> = smooth.by_ref().take(kept).collect();
        pending.iter_mut().for_each(|pending| pending.power = smooth.by_ref().take(2).collect());
        if level + 1 >= SMOOTHINGS && !pending.is_empty() {
            pending.remove(0).add_significant(&mut found, settings.significance);
        }
        if !last {
            let mut detail = Pending::of(&residual, &coarse, &shares, &relative);
            detail.power = kernel.smooth(&detail.power, step);
            pending.push(detail);
            residual = coarse;
            monitor.advance(1);
        }
    }
    picture.channels_mut().par_iter_mut().zip(&found).enumerate().for_each(|(c, (plane, found))| {
        for (i, (value, found)) in plane.iter_mut().zip(found).enumerate() {
            let rest: f32 = shares.iter().enumerate().map(|(g, share)| share[i] * residual[3 * g + c][i]).sum();
            *value = (*value + found + rest).max(0.0);
        }
    });
    Ok(())
}

/// The share of each group in the mean of every pixel.
fn group_shares(counts: &SampleCounts, pixels: usize, groups: usize) -> Vec<Vec<f32>> {
    let grouped = counts.grouped(groups);
    let share = |pixel: usize, group: usize| grouped.of(pixel, group) as f32 / counts.total[pixel].max(1) as f32;
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

/// One scale of the residual, whose significance is not known yet.
struct Pending {
    /// Mean over buckets, three planes.
    mean: Vec<Vec<f32>>,
    /// Its square and its variance, relative, summed over channels, and smoothed as far as they are.
    power: Vec<Vec<f32>>,
}

impl Pending {
    fn of(fine: &[Vec<f32>], coarse: &[Vec<f32>], shares: &[Vec<f32>], relative: &[f32]) -> Self {
        let pixel = |pixel: usize| {
            let filled = shares.iter().filter(|share| share[pixel] > 0.0).count();
            let scale = relative[pixel] / filled.saturating_sub(1).max(1) as f32;
            let mut numbers = [0.0; 5];
            for c in 0..3 {
                let at = |g: usize| fine[3 * g + c][pixel] - coarse[3 * g + c][pixel];
                let mean: f32 = shares.iter().enumerate().map(|(g, share)| share[pixel] * at(g)).sum();
                let spread = |(g, share): (usize, &Vec<f32>)| share[pixel] * (at(g) - mean).powi(2);
                numbers[c] = mean;
                numbers[3] += relative[pixel] * mean * mean;
                numbers[4] += scale * shares.iter().enumerate().map(spread).sum::<f32>();
            }
            numbers
        };
        let mut planes = per_pixel::planes(relative.len(), pixel).into_iter();
        Self { mean: planes.by_ref().take(3).collect(), power: planes.collect() }
    }

    /// Adds its significant part to `found`.
    fn add_significant(self, found: &mut [Vec<f32>], significance: f32) {
        let (squares, variances) = (&self.power[0], &self.power[1]);
        found.par_iter_mut().zip(&self.mean).for_each(|(found, mean)| {
            for (i, (found, mean)) in found.iter_mut().zip(mean).enumerate() {
                *found += ((squares[i] - significance * variances[i]) / (squares[i] + 1e-20)).max(0.0) * mean;
            }
        });
    }
}

#[cfg(test)]
mod tests;
