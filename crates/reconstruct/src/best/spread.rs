//! Events spread over the pixels that resemble their own: their light is real, only its place is chance.

pub mod lines;
mod occurrences;

use std::ops::Range;

use rayon::prelude::*;
use stack::{Cancelled, Image, Monitor, Size};

use super::cascade::{Parts, Scrutiny, add_significant_residual, relative_to};
use super::edge_avoiding::EdgeAvoidingKernel;
use super::features::CleanFeatures;
use super::halves::sum_of;
use super::settings::SpreadSettings;
use super::split::Events;
use crate::exp::exp_of_negative;
use crate::per_pixel::plane;
use crate::rectangle::{Rectangle, tiles_of};
use occurrences::{Occurrence, Occurrences};

/// Radius at which kernels end, in deviations and in pixels.
const REACH: f32 = 2.5;
const LARGEST_REACH: usize = 20;

/// How many kernels one after the other, each twice as wide, tell whether a surface ends.
const WIDTH_OF_MASS: usize = 2;
/// Mass of a pixel at a straight edge; with less, on what is narrow, others are not near either.
const LEAST_MASS: f32 = 0.5;

/// Side of the tiles whose events are spread together.
const TILE: usize = 64;

/// Events after they were spread.
#[derive(Clone, Debug)]
pub struct Spread {
    /// Light of the events of either half; their sum is that of all.
    pub halves: [Image; 2],
    /// Variance of the sum, mean over RGB: Σ K² e² over events e that reach a pixel with kernel K, for they come and go
    /// by chance (a compound Poisson process).
    pub variance: Vec<f32>,
}

/// The light of `events`, spread. Each is spread just so wide that the surroundings it shares hold enough others; its
/// kernel is a Gaussian times the likeness of pixels in `features` and in the brightness of `picture`, and sums to one.
/// Brighter pixels take more of it, for there it may have met with more; and so do those at the end of a surface, where fewer
/// events are near.
pub fn spread(events: &Events, picture: &Image, features: &CleanFeatures, settings: &SpreadSettings) -> Spread {
    let size = picture.size();
    let brightness = plane(size.pixels(), |pixel| finite_in_the_dark(picture.mean_at(pixel)));
    let separators = separators(&brightness, features, settings);
    let occurrences = Occurrences::new(events, &separators, size, settings.events);
    let mut shares = plane(size.pixels(), |pixel| brightness[pixel].powf(settings.share));
    // Weighing the kernel takes a tenth of what `fast` does in all.
    if settings.levels > 0 {
        let mass = kernel(features, picture, settings).mass(WIDTH_OF_MASS);
        shares.iter_mut().zip(mass).for_each(|(share, mass)| *share /= mass.max(LEAST_MASS));
    }
    let task = |tile: &Rectangle| TileTask {
        size,
        separators: &separators,
        shares: &shares,
        occurrences: &occurrences,
        tile: *tile,
    };
    let parts: Vec<(Rectangle, Vec<Vec<f32>>)> =
        tiles_of(size, TILE).par_iter().map(|tile| pulp::Arch::new().dispatch(task(tile))).collect();
    let mut spread = Spread { halves: [0, 1].map(|_| Image::zeros(size, 3)), variance: vec![0.0; size.pixels()] };
    let light = spread.halves.iter_mut().flat_map(|half| half.channels_mut());
    let planes: Vec<&mut Vec<f32>> = light.chain([&mut spread.variance]).collect();
    planes.into_par_iter().enumerate().for_each(|(number, plane)| {
        for (place, part) in &parts {
            for (y, row) in (place.y0..place.y1).zip(part[number].chunks_exact(place.width())) {
                let to = &mut plane[size.index(place.x0, y)..][..row.len()];
                to.iter_mut().zip(row).for_each(|(sum, v)| *sum += v);
            }
        }
    });
    spread
}

/// `halves` of spread light added up, without blotches that only one of them shows: a few events, spread so wide that
/// they overlap, still leave hills and valleys of a third of their mean.
///
/// # Errors
/// When `monitor` cancels.
pub fn steadied(
    halves: [Image; 2],
    picture: &Image,
    features: &CleanFeatures,
    settings: &SpreadSettings,
    monitor: &dyn Monitor,
) -> Result<Image, Cancelled> {
    let sum = sum_of(&halves);
    if settings.levels == 0 {
        return Ok(sum);
    }
    let mut brightness = picture.clone();
    brightness.add(&sum);
    let relative = relative_to(&brightness);
    drop((sum, brightness));
    let SpreadSettings { levels, significance, .. } = *settings;
    let kernel = kernel(features, picture, settings);
    let mut steady = Image::zeros(picture.size(), 3);
    let scrutiny = Scrutiny { levels, trusted: 0, significance, gain: 1.0 };
    let taps = |step| kernel.taps(step);
    add_significant_residual(&mut steady, Parts::adding_up(halves), relative, taps, scrutiny, monitor)?;
    Ok(steady)
}

/// A kernel that takes the same pixels for alike as events do.
fn kernel<'a>(features: &'a CleanFeatures, picture: &Image, settings: &SpreadSettings) -> EdgeAvoidingKernel<'a> {
    let brightness = settings.brightness.powi(2);
    EdgeAvoidingKernel::on_surfaces_of_like_brightness(features, picture, settings.feature_scale, brightness)
}

/// Planes that separate pixels, scaled so that their likeness is exp(−Σ Δ²).
fn separators(brightness: &[f32], features: &CleanFeatures, settings: &SpreadSettings) -> Vec<Vec<f32>> {
    let scale = std::f32::consts::FRAC_1_SQRT_2 / settings.feature_scale;
    let pixels = brightness.len();
    let scaled = |values: &[f32]| plane(pixels, |pixel| scale * values[pixel]);
    let mut planes: Vec<Vec<f32>> = features.separators().map(scaled).collect();
    planes.push(plane(pixels, |pixel| scale * settings.brightness * brightness[pixel].ln()));
    planes
}

/// A luminance of which there is a logarithm.
fn finite_in_the_dark(luminance: f32) -> f32 {
    (luminance + 0.01).max(0.005)
}

/// What is summed at a pixel: light of either half, three channels each, and variance.
const SUMS: usize = 7;

struct TileTask<'a> {
    size: Size,
    /// See [`separators`].
    separators: &'a [Vec<f32>],
    /// What a pixel takes of an event, beside its likeness.
    shares: &'a [f32],
    occurrences: &'a Occurrences,
    tile: Rectangle,
}

impl pulp::NullaryFnOnce for TileTask<'_> {
    /// The light of the events of a tile, in [`SUMS`] planes, and where it lies.
    type Output = (Rectangle, Vec<Vec<f32>>);

    #[inline(always)]
    fn call(self) -> Self::Output {
        let place = self.tile.grown(LARGEST_REACH, self.size);
        let mut sums = vec![vec![0.0; place.width() * place.height()]; SUMS];
        let mut weights = Vec::new();
        for y in self.tile.y0..self.tile.y1 {
            for occurrence in self.occurrences.of_row(y, self.tile.x0..self.tile.x1) {
                self.spread_one(occurrence, place, &mut weights, &mut sums);
            }
        }
        (place, sums)
    }
}

impl TileTask<'_> {
    #[inline(always)]
    fn spread_one(&self, event: &Occurrence, place: Rectangle, weights: &mut Vec<f32>, sums: &mut [Vec<f32>]) {
        let sigma = self.occurrences.sigma(event);
        let disc = Disc { centre: event.place, radius: (REACH * sigma).max(0.3), size: self.size };
        weights.clear();
        for (row, columns) in disc.rows() {
            self.weigh(event.place, sigma, row, columns, weights);
        }
        let norm: f32 = weights.iter().sum();
        let own = event.light.map(|light| light / norm);
        let square = event.concentration * (0..3).map(|c| (own[c] + own[c + 3]).powi(2)).sum::<f32>() / 3.0;
        let mut weights = &weights[..];
        for (row, columns) in disc.rows() {
            let (of_row, others) = weights.split_at(columns.len());
            let at = (row - place.y0) * place.width() + columns.start - place.x0;
            // Most events are in one half.
            for (plane, light) in sums.iter_mut().zip(own).filter(|(_, light)| *light != 0.0) {
                let plane = &mut plane[at..at + of_row.len()];
                plane.iter_mut().zip(of_row).for_each(|(sum, weight)| *sum += weight * light);
            }
            let variance = &mut sums[SUMS - 1][at..at + of_row.len()];
            variance.iter_mut().zip(of_row).for_each(|(sum, weight)| *sum += weight * weight * square);
            weights = others;
        }
    }

    /// Adds the weights that an event at column `x`, row `y` has for some pixels of a row.
    #[inline(always)]
    fn weigh(&self, [x, y]: [usize; 2], sigma: f32, row: usize, columns: Range<usize>, weights: &mut Vec<f32>) {
        let (first, own) = (weights.len(), self.size.index(x, y));
        let scale = 1.0 / (2.0 * sigma * sigma);
        let across = row.abs_diff(y).pow(2);
        weights.extend(columns.clone().map(|column| scale * (column.abs_diff(x).pow(2) + across) as f32));
        let weights = &mut weights[first..];
        for plane in self.separators {
            let (own, there) = (plane[own], &plane[self.size.index(columns.start, row)..][..columns.len()]);
            weights.iter_mut().zip(there).for_each(|(sum, v)| *sum += (v - own) * (v - own));
        }
        let shares = &self.shares[self.size.index(columns.start, row)..][..columns.len()];
        weights.iter_mut().zip(shares).for_each(|(weight, share)| *weight = share * exp_of_negative(-*weight));
    }
}

/// Pixels of an image of `size` whose middle lies within `radius` of a pixel's, and within the largest reach.
#[derive(Clone, Copy)]
struct Disc {
    centre: [usize; 2],
    radius: f32,
    size: Size,
}

impl Disc {
    /// Its rows, and the columns of each.
    #[inline(always)]
    fn rows(self) -> impl Iterator<Item = (usize, Range<usize>)> {
        let [x, y] = self.centre;
        let reach = (self.radius as usize).min(LARGEST_REACH);
        (y.saturating_sub(reach)..(y + reach + 1).min(self.size.height)).map(move |row| {
            let across = row.abs_diff(y).pow(2) as f32;
            let half = ((self.radius * self.radius - across).max(0.0).sqrt() as usize).min(LARGEST_REACH);
            (row, x.saturating_sub(half)..(x + half + 1).min(self.size.width))
        })
    }
}

#[cfg(test)]
mod tests;
