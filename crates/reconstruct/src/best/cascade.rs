//! What the residual of a picture still holds, from fine to coarse.

use rayon::prelude::*;
use stack::{Cancelled, Image, Monitor, SampleCounts};

use super::guided_kernel::GuidedKernel;
use super::settings::CascadeSettings;
use crate::per_pixel;

/// How often the significance of a detail is smoothed: at its own scale, and at so many less one of the next.
const SMOOTHINGS: usize = 3;

/// Most parts that a picture comes in.
pub const MOST_PARTS: usize = 8;

/// Independent parts of a picture, at most [`MOST_PARTS`].
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
/// details of growing scale. A detail d counts by E\[s\]/E\[d²\]; s = d² − c v is its signal, v its variance between
/// parts and c the significance. Squares are relative to `brightness`. Of more than two parts each is left out once, and
/// the least signal counts: a firefly, which is in one part, is none. What is left at the coarsest scale counts in full.
/// Never below zero. Reports the stage `cascade`.
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
    let Parts { images, shares } = parts;
    let parting = Parting::new(shares, brightness, settings);
    let mut residual = residuals(images, picture);
    let mut found = vec![vec![0.0; picture.pixels()]; 3];
    let mut pending: Vec<Pending> = Vec::new();
    // A detail is smoothed at its own scale and along with the residual at the next two.
    for level in 0..settings.levels + SMOOTHINGS - 1 {
        if monitor.cancelled() {
            return Err(Cancelled);
        }
        let (step, last) = (1 << level, level >= settings.levels);
        let coarse = smoothed(kernel, step, if last { &[] } else { &residual }, &mut pending);
        if level + 1 >= SMOOTHINGS && !pending.is_empty() {
            pending.remove(0).add_significant(&mut found);
        }
        if !last {
            let mut detail = parting.detail(&residual, &coarse);
            smoothed(kernel, step, &[], std::slice::from_mut(&mut detail));
            pending.push(detail);
            residual = coarse;
            monitor.advance(1);
        }
    }
    let shares = &parting.shares;
    picture.channels_mut().par_iter_mut().zip(&found).enumerate().for_each(|(c, (plane, found))| {
        for (i, (value, found)) in plane.iter_mut().zip(found).enumerate() {
            let rest: f32 = shares.iter().enumerate().map(|(g, share)| share[i] * residual[3 * g + c][i]).sum();
            *value = (*value + found + rest).max(0.0);
        }
    });
    Ok(())
}

/// `residual`, smoothed by `kernel` with taps `step` pixels apart; along with it, in place, what is `pending`.
fn smoothed(kernel: &GuidedKernel, step: usize, residual: &[Vec<f32>], pending: &mut [Pending]) -> Vec<Vec<f32>> {
    let planes: Vec<&Vec<f32>> = residual.iter().chain(pending.iter().flat_map(Pending::powers)).collect();
    let mut smooth = kernel.smooth(&planes, step).into_iter();
    let coarse = smooth.by_ref().take(residual.len()).collect();
    pending.iter_mut().flat_map(Pending::powers_mut).zip(smooth).for_each(|(power, smooth)| *power = smooth);
    coarse
}

/// One over the squared luminance of a picture.
fn relative_to(brightness: &Image) -> Vec<f32> {
    (0..brightness.pixels())
        .map(|pixel| {
            let luminance = brightness.mean_at(pixel);
            1.0 / (luminance * luminance + 1e-2)
        })
        .collect()
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

/// How details are judged.
struct Parting {
    shares: Vec<Vec<f32>>,
    /// What squares are multiplied by.
    relative: Vec<f32>,
    significance: f32,
    /// The part that each signal does without; none when there are but two.
    without: Vec<Option<usize>>,
}

/// One scale of the residual, whose significance is not known yet.
struct Pending {
    /// Mean over parts, three planes.
    mean: Vec<Vec<f32>>,
    /// Its square, relative, summed over channels, and smoothed as far as it is.
    square: Vec<f32>,
    /// The same of the signal: once, or with each part left out.
    signals: Vec<Vec<f32>>,
}

impl Parting {
    fn new(shares: Vec<Vec<f32>>, brightness: &Image, settings: &CascadeSettings) -> Self {
        let (significance, without) = match shares.len() {
            ..=2 => (settings.significance_of_two, vec![None]),
            parts => (settings.significance, (0..parts).map(Some).collect()),
        };
        Self { shares, relative: relative_to(brightness), significance, without }
    }

    /// What the residual `fine` has beyond `coarse`.
    fn detail(&self, fine: &[Vec<f32>], coarse: &[Vec<f32>]) -> Pending {
        let pixel = |pixel: usize| {
            let mut numbers = [0.0; 4 + MOST_PARTS];
            for c in 0..3 {
                let mut parts = [Moments::default(); MOST_PARTS];
                for (g, (part, share)) in parts.iter_mut().zip(&self.shares).enumerate() {
                    *part = Moments::of(share[pixel], fine[3 * g + c][pixel] - coarse[3 * g + c][pixel]);
                }
                let mean = Moments::sum(&parts, None).first;
                numbers[c] = mean;
                numbers[3] += mean * mean;
                for (signal, without) in numbers[4..].iter_mut().zip(&self.without) {
                    *signal += Moments::sum(&parts, *without).signal(self.significance);
                }
            }
            numbers[3..].iter_mut().for_each(|square| *square *= self.relative[pixel]);
            numbers
        };
        let mut planes = per_pixel::planes(self.relative.len(), pixel).into_iter();
        Pending {
            mean: planes.by_ref().take(3).collect(),
            square: planes.next().unwrap_or_default(),
            signals: planes.take(self.without.len()).collect(),
        }
    }
}

/// Sums over parts.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    /// How many have samples.
    filled: usize,
    share: f32,
    first: f32,
    second: f32,
}

impl Moments {
    fn of(share: f32, value: f32) -> Self {
        Self { filled: usize::from(share > 0.0), share, first: share * value, second: share * value * value }
    }

    /// Sums over `parts` but the one `without`.
    fn sum(parts: &[Self], without: Option<usize>) -> Self {
        let others = parts.iter().enumerate().filter(|(g, _)| Some(*g) != without);
        others.fold(Self::default(), |sum, (_, part)| Self {
            filled: sum.filled + part.filled,
            share: sum.share + part.share,
            first: sum.first + part.first,
            second: sum.second + part.second,
        })
    }

    /// m² − c v of the mean m, whose variance is v and c the significance; 0 where one part says nothing of it.
    fn signal(self, significance: f32) -> f32 {
        if self.filled < 2 {
            return 0.0;
        }
        let mean = self.first / self.share;
        let variance = (self.second / self.share - mean * mean).max(0.0) / (self.filled - 1) as f32;
        mean * mean - significance * variance
    }
}

impl Pending {
    fn powers(&self) -> impl Iterator<Item = &Vec<f32>> {
        std::iter::once(&self.square).chain(&self.signals)
    }

    fn powers_mut(&mut self) -> impl Iterator<Item = &mut Vec<f32>> {
        std::iter::once(&mut self.square).chain(&mut self.signals)
    }

    /// Adds its significant part to `found`.
    fn add_significant(self, found: &mut [Vec<f32>]) {
        let Self { mean, square, signals } = self;
        let gain = |i: usize| {
            let signal = signals.iter().map(|signal| signal[i]).fold(f32::INFINITY, f32::min);
            (signal / (square[i] + 1e-20)).clamp(0.0, 1.0)
        };
        let gains: Vec<f32> = (0..square.len()).into_par_iter().map(gain).collect();
        found.par_iter_mut().zip(&mean).for_each(|(found, mean)| {
            found.iter_mut().zip(mean).zip(&gains).for_each(|((found, mean), gain)| *found += gain * mean);
        });
    }
}

#[cfg(test)]
mod tests;
