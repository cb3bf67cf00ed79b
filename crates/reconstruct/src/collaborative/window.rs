//! The pixels of a window, and what they weigh in its fit.

use super::region::Region;
use super::row::{FEATURES, WIDTH};
use crate::eight::{LANES, sum_of_lanes};
use crate::exp::exp_of_negative;

/// Pixels of less weight have no say in a fit, nor it in them.
const NEGLIGIBLE: f32 = 1e-4;

/// All pixels of one window, row by row, one list per property; lists are padded with zeros to a multiple of [`LANES`].
/// Buffers are kept between fits.
#[derive(Debug)]
pub struct Window {
    side: usize,
    length: usize,
    /// Features and responses relative to the centre's, list after list.
    columns: Vec<f32>,
    noise: Vec<f32>,
    importance: Vec<f32>,
}

impl Window {
    /// For windows of `side` × `side` pixels.
    pub fn new(side: usize) -> Self {
        let length = (side * side).next_multiple_of(LANES);
        let columns = vec![0.0; WIDTH * length];
        Self { side, length, columns, noise: vec![0.0; length], importance: Vec::new() }
    }

    /// Numbers in a list.
    pub fn length(&self) -> usize {
        self.length
    }

    /// Features (all that there can be, then all responses) of every pixel.
    #[inline(always)]
    pub fn column(&self, number: usize) -> &[f32] {
        &self.columns[number * self.length..][..self.length]
    }

    /// Fetches the window around the pixel `centre` from a region whose planes are `features` features, then
    /// `responses` responses, the noise and, when there are more planes, the importance.
    #[inline(always)]
    pub fn fetch(&mut self, region: &Region, centre: [usize; 2], features: usize, responses: usize, weighed: bool) {
        let Self { side, length, .. } = *self;
        for plane in 0..features + responses {
            let column = if plane < features { plane } else { FEATURES + plane - features };
            let own = region.from(region.index(plane, centre[0], centre[1]))[0];
            let to = &mut self.columns[column * length..][..length];
            copy_rows(region, region.window_index(plane, centre), side, to, |value| value - own);
        }
        let plane = features + responses;
        copy_rows(region, region.window_index(plane, centre), side, &mut self.noise, |value| value);
        if weighed {
            self.importance.resize(length, 0.0);
            let own = 1.0 / region.from(region.index(plane + 1, centre[0], centre[1]))[0];
            let start = region.window_index(plane + 1, centre);
            copy_rows(region, start, side, &mut self.importance, |value| value * own);
        }
    }

    /// Weights of residuals, from those of predictions, `kernel`.
    #[inline(always)]
    pub fn weigh_residuals(&self, kernel: &[f32], weights: &mut [f32]) {
        if self.importance.is_empty() {
            weights.copy_from_slice(kernel);
            return;
        }
        let (kernel, importance) = (&kernel[..weights.len()], &self.importance[..weights.len()]);
        for i in 0..weights.len() {
            weights[i] = kernel[i] * importance[i];
        }
    }

    /// Σ k² ν over the window, k of `kernel`.
    #[inline(always)]
    pub fn noise(&self, kernel: &[f32]) -> f32 {
        let mut sums = [0.0; LANES];
        for (kernel, noise) in kernel.chunks_exact(LANES).zip(self.noise.chunks_exact(LANES)) {
            for i in 0..LANES {
                sums[i] += kernel[i] * kernel[i] * noise[i];
            }
        }
        sum_of_lanes(&sums)
    }
}

#[inline(always)]
fn copy_rows(region: &Region, start: usize, side: usize, to: &mut [f32], value: impl Fn(f32) -> f32) {
    for row in 0..side {
        let from = &region.from(start + row * region.width())[..side];
        let to = &mut to[row * side..][..side];
        for i in 0..side {
            to[i] = value(from[i]);
        }
    }
}

/// Weights exp(−D `scale` − `falloff`) of the patches' `distances` D; the small ones are zero.
#[inline(always)]
pub fn weigh(distances: &[f32], scale: f32, falloff: &[f32], weights: &mut [f32]) {
    let count = distances.len();
    let (falloff, weights) = (&falloff[..count], &mut weights[..count]);
    for i in 0..count {
        let weight = exp_of_negative(-(distances[i] * scale + falloff[i]));
        weights[i] = if weight >= NEGLIGIBLE { weight } else { 0.0 };
    }
}

#[cfg(test)]
mod tests;
