//! What the residual of a picture still holds, from fine to coarse.

mod parting;

use rayon::prelude::*;
use stack::{Cancelled, Image, Monitor, SampleCounts, planes_of_zeros};

use super::edge_avoiding::{Seamless, Taps};
use super::halves::luminance;
use super::settings::CascadeSettings;
use crate::per_pixel::{plane, planes_by_eight};
pub use parting::{MOST_PARTS, relative_to};
use parting::{Parting, Residuals};

/// Independent parts of a picture, at most [`MOST_PARTS`]: details are judged by luminance, so that colours of their mean
/// are all that is kept of colour.
pub struct Parts {
    luminances: Vec<Vec<f32>>,
    /// The share of each in the mean of every pixel.
    shares: Vec<Vec<f32>>,
    /// That mean, three planes.
    mean: Vec<Vec<f32>>,
}

impl Parts {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.luminances.len()
    }

    /// `images` as they come from [`stack::Estimate::groups`].
    pub fn new(images: Vec<Image>, counts: &SampleCounts) -> Self {
        let pixels = images.first().map_or(0, Image::pixels);
        let shares = group_shares(counts, pixels, images.len());
        Self::of(&images, shares)
    }

    fn of(images: &[Image], shares: Vec<Vec<f32>>) -> Self {
        let mut mean = planes_of_zeros(images.first().map_or(0, Image::pixels), 3);
        mean.par_iter_mut().enumerate().for_each(|(c, mean)| {
            for (image, shares) in images.iter().zip(&shares) {
                let values = image.channels()[c].iter().zip(shares);
                mean.iter_mut().zip(values).for_each(|(mean, (value, share))| *mean += share * value);
            }
        });
        Self { luminances: images.par_iter().map(luminance).collect(), shares, mean }
    }

    /// Two images whose sum is the picture.
    pub fn adding_up(mut images: [Image; 2]) -> Self {
        images.iter_mut().flat_map(Image::channels_mut).flatten().for_each(|v| *v *= 2.0);
        Self::halves(&images)
    }

    /// Two images whose mean is the picture.
    pub fn halves(images: &[Image; 2]) -> Self {
        Self::of(images, vec![vec![0.5; images[0].pixels()]; 2])
    }
}

/// How closely details are looked at.
#[derive(Clone, Copy, Debug)]
pub struct Scrutiny {
    /// Scales, each twice as coarse as the one before.
    pub levels: usize,
    /// How many of them, the finest, count in full.
    pub trusted: usize,
    /// Multiple of a detail's variance that its square must exceed.
    pub significance: f32,
    /// Multiple of the share of signal in it that a detail counts by, at most in full.
    pub gain: f32,
}

impl CascadeSettings {
    /// How details of so many `parts` are looked at.
    pub fn scrutiny(&self, parts: usize) -> Scrutiny {
        let significance = if parts > 2 { self.significance } else { self.significance_of_two };
        Scrutiny { levels: self.levels, trusted: 0, significance, gain: 1.0 }
    }
}

/// Adds to `picture` what `parts` agree on and it lacks: the residual of each part, taken apart by a kernel into
/// details of growing scale; `taps_of` are those of the kernel, so many pixels apart, and each is asked for once, the finest
/// first. A detail of luminance d counts by E\[s\]/E\[d²\], times the gain; s = d² − c v is its signal, v its variance
/// between parts and c the significance; colours count as much. Squares are multiplied by `relative`. Of more than two
/// parts each is left out once, and the least signal counts: a firefly, which is in one part, is none. Both are smoothed at
/// the detail's own scale and the next two. What is left at the coarsest scale counts in full. Never below zero. Reports the
/// stage `cascade`.
///
/// # Errors
/// When `monitor` cancels.
pub fn add_significant_residual(
    picture: &mut Image,
    parts: Parts,
    relative: Vec<f32>,
    taps_of: impl FnMut(usize) -> Taps,
    scrutiny: Scrutiny,
    monitor: &dyn Monitor,
) -> Result<(), Cancelled> {
    monitor.begin("cascade", scrutiny.levels as u64);
    let (mut residual, shares) = residuals(parts, picture);
    let parting = Parting::new(shares, relative, scrutiny.significance);
    let mut found = planes_of_zeros(picture.pixels(), 3);
    let mut kernel = Seamless::new(taps_of);
    let (mut taps, mut next) = (kernel.taps(1), kernel.taps(2));
    for level in 0..scrutiny.levels {
        if monitor.cancelled() {
            return Err(Cancelled);
        }
        let coarse = taps.smooth(&residual);
        // Weighed once for three levels, and never more than two at a time: taps take more memory than anything else.
        if level < scrutiny.trusted {
            add_difference(&mut found, &residual[parting.parts()..], &coarse[parting.parts()..]);
            residual = coarse;
            taps = next;
            next = kernel.taps(4 << level);
        } else {
            let mut detail = Detail::new(&parting, &residual, &coarse);
            residual = coarse;
            detail.smooth(&taps);
            taps = next;
            detail.smooth(&taps);
            next = kernel.taps(4 << level);
            detail.smooth(&next);
            detail.add_significant(scrutiny.gain, &mut found);
        }
        monitor.advance(1);
    }
    let rest = &residual[parting.parts()..];
    picture.channels_mut().par_iter_mut().zip(found.par_iter().zip(rest)).for_each(|(plane, (found, rest))| {
        plane.iter_mut().zip(found.iter().zip(rest)).for_each(|(v, (found, rest))| *v = (*v + found + rest).max(0.0));
    });
    Ok(())
}

/// Adds to `found` what `fine` has beyond `coarse`.
fn add_difference(found: &mut [Vec<f32>], fine: &[Vec<f32>], coarse: &[Vec<f32>]) {
    found.par_iter_mut().zip(fine.par_iter().zip(coarse)).for_each(|(found, (fine, coarse))| {
        found.iter_mut().zip(fine.iter().zip(coarse)).for_each(|(found, (fine, coarse))| *found += fine - coarse);
    });
}

/// The share of each group in the mean of every pixel.
fn group_shares(counts: &SampleCounts, pixels: usize, groups: usize) -> Vec<Vec<f32>> {
    let grouped = counts.grouped(groups);
    let share = |pixel: usize, group: usize| grouped.of(pixel, group) as f32 / counts.total[pixel].max(1) as f32;
    (0..groups).into_par_iter().map(|group| (0..pixels).map(|pixel| share(pixel, group)).collect()).collect()
}

/// What the luminance of each part has more than that of `picture`, then the same of their mean in every channel; and the
/// shares.
fn residuals(parts: Parts, picture: &Image) -> (Vec<Vec<f32>>, Vec<Vec<f32>>) {
    let Parts { mut luminances, shares, mut mean } = parts;
    let known: Vec<f32> = plane(picture.pixels(), |pixel| shares.iter().map(|shares| shares[pixel]).sum());
    mean.par_iter_mut().zip(picture.channels()).for_each(|(mean, whole)| {
        mean.iter_mut().zip(whole).zip(&known).for_each(|((mean, whole), known)| *mean -= known * whole);
    });
    let whole = luminance(picture);
    let of_mean = |pixel: usize| mean.iter().map(|plane| plane[pixel]).sum::<f32>() / 3.0;
    luminances.par_iter_mut().zip(&shares).for_each(|(part, shares)| {
        for (pixel, (part, whole)) in part.iter_mut().zip(&whole).enumerate() {
            // A part without samples says nothing here, and its neighbours are not to hear of black.
            *part = if shares[pixel] > 0.0 { *part - whole } else { of_mean(pixel) };
        }
    });
    luminances.extend(mean);
    (luminances, shares)
}

/// One scale of the residual.
struct Detail {
    /// Mean over parts, three planes.
    mean: Vec<Vec<f32>>,
    /// The square of its luminance, relative, and smoothed as far as it is.
    square: Vec<f32>,
    /// The same of its signal: once, or with each part left out.
    signals: Vec<Vec<f32>>,
}

impl Detail {
    /// What the residual `fine` has beyond `coarse`.
    fn new(parting: &Parting, fine: &[Vec<f32>], coarse: &[Vec<f32>]) -> Self {
        let (pixels, residuals) = (fine[0].len(), Residuals { parting, fine, coarse });
        let planes = match parting.signals() {
            1 => Vec::from(planes_by_eight::<5>(pixels, &residuals)),
            _ => Vec::from(planes_by_eight::<{ 4 + MOST_PARTS }>(pixels, &residuals)),
        };
        let mut planes = planes.into_iter();
        Self {
            mean: planes.by_ref().take(3).collect(),
            square: planes.next().unwrap_or_default(),
            signals: planes.take(parting.signals()).collect(),
        }
    }

    /// Smooths what decides on its significance.
    fn smooth(&mut self, taps: &Taps) {
        let powers: Vec<&Vec<f32>> = std::iter::once(&self.square).chain(&self.signals).collect();
        let smooth = taps.smooth(&powers);
        let powers = std::iter::once(&mut self.square).chain(&mut self.signals);
        powers.zip(smooth).for_each(|(power, smooth)| *power = smooth);
    }

    /// Adds its significant part to `found`.
    fn add_significant(self, gain: f32, found: &mut [Vec<f32>]) {
        let Self { mean, square, signals } = self;
        let share = |i: usize| {
            let signal = signals.iter().map(|signal| signal[i]).fold(f32::INFINITY, f32::min);
            (gain * (signal / (square[i] + 1e-20))).clamp(0.0, 1.0)
        };
        let shares: Vec<f32> = (0..square.len()).into_par_iter().map(share).collect();
        found.par_iter_mut().zip(&mean).for_each(|(found, mean)| {
            found.iter_mut().zip(mean).zip(&shares).for_each(|((found, mean), share)| *found += share * mean);
        });
    }
}

#[cfg(test)]
mod tests;
