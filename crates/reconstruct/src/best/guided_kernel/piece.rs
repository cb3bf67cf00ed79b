//! A few pixels side by side, and what their taps weigh.

use std::ops::Range;

use pulp::Simd;
use stack::Size;

use crate::eight::{Eight, LANES};
use crate::exp::exp_of_negative;

/// The B₃ spline.
const SPLINE: [f32; 5] = [0.0625, 0.25, 0.375, 0.25, 0.0625];
const TAPS: usize = SPLINE.len() * SPLINE.len();

/// Most pixels of a piece: all its weights stay in the innermost cache.
pub const PIXELS: usize = 128;
/// Planes that are smoothed together, and pixels (times eight): as many sums as the processor has registers for.
pub const PLANES: usize = 3;
const BATCHES: usize = 4;

/// Consecutive pixels of a row that have the same taps.
pub struct Piece<'a> {
    size: Size,
    guides: &'a [Vec<f32>],
    /// Pixels from tap to tap.
    step: usize,
    /// Where each tap of the first pixel lies in a plane.
    taps: [usize; TAPS],
    count: usize,
    weights: [[f32; PIXELS]; TAPS],
    /// One over the sum of a pixel's weights.
    scale: [f32; PIXELS],
}

impl<'a> Piece<'a> {
    /// Room for one in a picture of `size`, whose pixels the `guides` separate, with taps `step` pixels apart.
    pub fn new(size: Size, guides: &'a [Vec<f32>], step: usize) -> Self {
        let (weights, scale) = ([[0.0; PIXELS]; TAPS], [0.0; PIXELS]);
        Self { size, guides, step, taps: [0; TAPS], count: 0, weights, scale }
    }

    /// Weighs the taps of the `pixels` of row `y`. All of the pixels must have the same ones.
    #[inline(always)]
    pub fn weigh<S: Simd>(&mut self, simd: S, y: usize, pixels: Range<usize>) {
        let Self { size, guides, step, .. } = *self;
        let here = size.index(pixels.start, y);
        let tap = |place: usize, number: usize| (place + number * step).checked_sub(SPLINE.len() / 2 * step);
        (self.count, self.scale) = (0, [0.0; PIXELS]);
        for (j, across) in SPLINE.iter().enumerate() {
            let Some(row) = tap(y, j).filter(|row| *row < size.height) else { continue };
            for (i, along) in SPLINE.iter().enumerate() {
                let Some(column) = tap(pixels.start, i).filter(|column| *column < size.width) else { continue };
                let (there, weights) = (size.index(column, row), &mut self.weights[self.count]);
                for at in whole_batches(pixels.len()) {
                    squares::<S, BATCHES>(simd, guides, here + at, there + at, &mut weights[at..]);
                }
                for at in rest(pixels.len()) {
                    squares::<S, 1>(simd, guides, here + at, there + at, &mut weights[at..]);
                }
                for (weight, sum) in weights.iter_mut().zip(&mut self.scale) {
                    *weight = across * along * exp_of_negative(-*weight);
                    *sum += *weight;
                }
                self.taps[self.count] = there;
                self.count += 1;
            }
        }
        self.scale.iter_mut().for_each(|scale| *scale = 1.0 / *scale);
    }

    /// Smooths these pixels of some `planes` into the rows `out`.
    #[inline(always)]
    pub fn smooth<S: Simd, const P: usize>(&self, simd: S, planes: [&[f32]; P], mut out: [&mut [f32]; P]) {
        for at in whole_batches(out[0].len()) {
            self.batch::<S, P, BATCHES>(simd, &planes, at, &mut out);
        }
        for at in rest(out[0].len()) {
            self.batch::<S, P, 1>(simd, &planes, at, &mut out);
        }
    }

    /// `B` times eight pixels from number `at` on.
    #[inline(always)]
    fn batch<S: Simd, const P: usize, const B: usize>(
        &self,
        simd: S,
        planes: &[&[f32]; P],
        at: usize,
        out: &mut [&mut [f32]; P],
    ) {
        let mut sums = [[Eight::splat(simd, 0.0); B]; P];
        for (tap, weights) in self.taps[..self.count].iter().zip(&self.weights) {
            for p in 0..P {
                let values = from::<B>(planes[p], tap + at);
                for b in 0..B {
                    let weight = Eight::load(simd, &weights[at + b * LANES..]);
                    sums[p][b] = weight.mul_add(simd, Eight::load_some(simd, &values[b * LANES..]), sums[p][b]);
                }
            }
        }
        for p in 0..P {
            for b in 0..B {
                let scale = Eight::load(simd, &self.scale[at + b * LANES..]);
                scale.mul(simd, sums[p][b]).store_some(&mut out[p][at + b * LANES..]);
            }
        }
    }
}

/// The first pixels of all whole batches of `count` pixels.
#[inline(always)]
fn whole_batches(count: usize) -> impl Iterator<Item = usize> {
    (0..count / (BATCHES * LANES)).map(|batch| batch * BATCHES * LANES)
}

/// The first of every eight pixels, or of fewer, that are left then.
#[inline(always)]
fn rest(count: usize) -> impl Iterator<Item = usize> {
    (count / (BATCHES * LANES) * BATCHES..count.div_ceil(LANES)).map(|eight| eight * LANES)
}

/// Values from number `start` on: whole batches know their length, the last eight may be fewer.
#[inline(always)]
fn from<const B: usize>(plane: &[f32], start: usize) -> &[f32] {
    if B > 1 { &plane[start..start + B * LANES] } else { &plane[start..] }
}

/// Σ Δ² between `B` times eight pixels from number `here` on and those from `there` on.
#[inline(always)]
fn squares<S: Simd, const B: usize>(simd: S, guides: &[Vec<f32>], here: usize, there: usize, squares: &mut [f32]) {
    let mut sums = [Eight::splat(simd, 0.0); B];
    for guide in guides {
        let (p, q) = (from::<B>(guide, here), from::<B>(guide, there));
        for b in 0..B {
            let here = Eight::load_some(simd, &p[b * LANES..]);
            let difference = here.sub(simd, Eight::load_some(simd, &q[b * LANES..]));
            sums[b] = difference.mul_add(simd, difference, sums[b]);
        }
    }
    for b in 0..B {
        sums[b].store(&mut squares[b * LANES..]);
    }
}
