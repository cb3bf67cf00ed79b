//! Events spread over the pixels that resemble their own: their light is real, only its place is chance.

use rayon::prelude::*;
use stack::{Cancelled, Image, Monitor, Size};

use super::cascade::{Parts, add_significant_residual};
use super::features::GuideFeatures;
use super::guided_kernel::GuidedKernel;
use super::halves::{luminance, sum_of};
use super::settings::{CascadeSettings, SpreadSettings};
use super::split::Events;
use crate::exp::exp_of_negative;
use crate::rectangle::{Rectangle, tiles_of};

/// Deviations to choose from, in pixels.
const SIGMAS: [f32; 9] = [0.4, 0.7, 1.0, 1.5, 2.2, 3.3, 5.0, 7.0, 9.0];

/// Radius of the disc in which events are counted, in deviations.
const COUNTED: f32 = 1.5;

/// Radius at which kernels end, in deviations and in pixels.
const REACH: f32 = 2.5;
const LARGEST_REACH: usize = 20;

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
pub fn spread(events: &Events, picture: &Image, features: &GuideFeatures, settings: &SpreadSettings) -> Spread {
    let size = picture.size();
    let task = SpreadTask { size, events, guides: guides(picture, features, settings), settings };
    let tiles = tiles_of(size, TILE);
    let parts: Vec<(Rectangle, Vec<Share>)> = tiles.par_iter().map(|tile| task.tile(*tile)).collect();
    let halves = [0, 1].map(|_| Image::zeros(size, 3));
    let mut spread = Spread { halves, variance: vec![0.0; size.pixels()] };
    for (place, part) in &parts {
        for (i, value) in part.iter().enumerate() {
            let pixel = size.index(place.x0 + i % place.width(), place.y0 + i / place.width());
            let planes = spread.halves.iter_mut().flat_map(|half| half.channels_mut());
            planes.zip(value.light).for_each(|(plane, v)| plane[pixel] += v);
            spread.variance[pixel] += value.variance;
        }
    }
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
    features: &GuideFeatures,
    settings: &SpreadSettings,
    monitor: &dyn Monitor,
) -> Result<Image, Cancelled> {
    let sum = sum_of(&halves);
    if settings.levels == 0 {
        return Ok(sum);
    }
    let mut brightness = picture.clone();
    brightness.add(&sum);
    let SpreadSettings { levels, significance, feature_scale, .. } = *settings;
    let kernel = GuidedKernel::surfaces_and_brightness(features, picture, feature_scale, settings.brightness.powi(2));
    let mut steady = Image::zeros(picture.size(), 3);
    let cascade =
        CascadeSettings { significance_of_two: significance, levels, feature_scale, ..CascadeSettings::default() };
    add_significant_residual(&mut steady, Parts::adding_up(halves), &brightness, &kernel, &cascade, monitor)?;
    Ok(steady)
}

/// One row per pixel: what separates pixels, scaled so that their likeness is exp(−Σ Δ²).
fn guides(picture: &Image, features: &GuideFeatures, settings: &SpreadSettings) -> PixelGuides {
    let scale = std::f32::consts::FRAC_1_SQRT_2 / settings.feature_scale;
    let mut planes = features.scaled_surfaces(scale);
    let brightness = |l: &f32| scale * settings.brightness * (l + 0.01).max(0.005).ln();
    planes.push(luminance(picture).iter().map(brightness).collect());
    let values = (0..picture.pixels()).flat_map(|pixel| planes.iter().map(move |plane| plane[pixel])).collect();
    PixelGuides { count: planes.len(), values }
}

/// Numbers that separate pixels, pixel after pixel.
struct PixelGuides {
    count: usize,
    values: Vec<f32>,
}

impl PixelGuides {
    fn of(&self, pixel: usize) -> &[f32] {
        &self.values[pixel * self.count..][..self.count]
    }
}

/// What reaches one pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    light: [f32; 6],
    variance: f32,
}

struct SpreadTask<'a> {
    size: Size,
    events: &'a Events,
    guides: PixelGuides,
    settings: &'a SpreadSettings,
}

impl SpreadTask<'_> {
    /// The light of the events of `tile`, and where it lies.
    fn tile(&self, tile: Rectangle) -> (Rectangle, Vec<Share>) {
        let place = tile.grown(LARGEST_REACH, self.size);
        let mut light = vec![Share::default(); place.width() * place.height()];
        let mut kernel = Vec::new();
        for y in tile.y0..tile.y1 {
            for x in tile.x0..tile.x1 {
                if self.events.energy[self.size.index(x, y)] > 0.0 {
                    self.spread_one([x, y], place, &mut kernel, &mut light);
                }
            }
        }
        (place, light)
    }

    fn spread_one(&self, [x, y]: [usize; 2], place: Rectangle, kernel: &mut Vec<(usize, f32)>, light: &mut [Share]) {
        let pixel = self.size.index(x, y);
        let sigma = self.sigma([x, y]);
        kernel.clear();
        for ([column, row], squared) in self.disc([x, y], (REACH * sigma).max(0.3)) {
            let weight =
                exp_of_negative(-squared / (2.0 * sigma * sigma)) * self.likeness(pixel, self.size.index(column, row));
            kernel.push(((row - place.y0) * place.width() + column - place.x0, weight));
        }
        let norm: f32 = kernel.iter().map(|(_, weight)| weight).sum();
        let [a, b] = [0, 1].map(|half: usize| self.events.light[half].rgb(pixel));
        let own: [f32; 6] = std::array::from_fn(|i| if i < 3 { a[i] } else { b[i - 3] } / norm);
        let square =
            (0..3).map(|c| (own[c] + own[c + 3]).powi(2)).sum::<f32>() / 3.0 * self.events.concentration(pixel);
        for (at, weight) in kernel.iter() {
            let share = &mut light[*at];
            share.light.iter_mut().zip(own).for_each(|(sum, v)| *sum += weight * v);
            share.variance += weight * weight * square;
        }
    }

    /// The least deviation whose surroundings hold enough events: Σγe squared over Σγe² counts them.
    fn sigma(&self, [x, y]: [usize; 2]) -> f32 {
        let pixel = self.size.index(x, y);
        let mut rings = [[0.0_f32; 2]; SIGMAS.len()];
        for ([column, row], squared) in self.disc([x, y], COUNTED * SIGMAS[SIGMAS.len() - 1]) {
            let near = self.size.index(column, row);
            if self.events.energy[near] > 0.0 {
                let ring = SIGMAS.partition_point(|sigma| squared > (COUNTED * sigma).powi(2));
                let likeness = self.likeness(pixel, near);
                if let Some(ring) = rings.get_mut(ring) {
                    ring[0] += likeness * self.events.energy[near];
                    ring[1] += likeness * self.events.squares[near];
                }
            }
        }
        let mut sums = [0.0; 2];
        for (ring, sigma) in rings.iter().zip(SIGMAS) {
            sums = [sums[0] + ring[0], sums[1] + ring[1]];
            if sums[0] * sums[0] >= self.settings.events * sums[1] {
                return sigma;
            }
        }
        SIGMAS[SIGMAS.len() - 1]
    }

    /// Pixels of the image within `radius` of a pixel and within the largest reach, with their squared distance.
    fn disc(&self, [x, y]: [usize; 2], radius: f32) -> impl Iterator<Item = ([usize; 2], f32)> {
        let reach = (radius.ceil() as usize).min(LARGEST_REACH);
        let columns = x.saturating_sub(reach)..(x + reach + 1).min(self.size.width);
        (y.saturating_sub(reach)..(y + reach + 1).min(self.size.height))
            .flat_map(move |row| columns.clone().map(move |column| [column, row]))
            .map(move |[column, row]| ([column, row], (column.abs_diff(x).pow(2) + row.abs_diff(y).pow(2)) as f32))
            .filter(move |(_, squared)| *squared <= radius * radius)
    }

    fn likeness(&self, p: usize, q: usize) -> f32 {
        let squares = self.guides.of(p).iter().zip(self.guides.of(q)).map(|(p, q)| (p - q) * (p - q));
        exp_of_negative(-squares.sum::<f32>())
    }
}

#[cfg(test)]
mod tests;
