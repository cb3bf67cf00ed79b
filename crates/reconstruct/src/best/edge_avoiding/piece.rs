//! A few pixels side by side, and what their taps weigh.

use std::ops::Range;

use pulp::Simd;

use super::taps::{PIXELS, TAPS, Taps};
use crate::eight::{Eight, LANES};

/// Planes that are smoothed together, and pixels (times eight): as many sums as the processor has registers for.
pub const PLANES: usize = 3;
const BATCHES: usize = 4;

/// Consecutive pixels of a row that have the same taps, at most [`PIXELS`].
pub struct Piece<'a> {
    /// Where each tap of the first pixel lies in a plane.
    taps: [usize; TAPS],
    /// What each weighs.
    weights: [&'a [f32]; TAPS],
    count: usize,
    /// One over the sum of a pixel's weights where means are wanted, one where sums are.
    scale: [f32; PIXELS],
}

impl<'a> Piece<'a> {
    /// Some `pixels` of row `y`, for means or for sums.
    #[inline(always)]
    pub fn new(taps: &'a Taps, y: usize, pixels: Range<usize>, are_means: bool) -> Self {
        let mut piece = Self { taps: [0; TAPS], weights: [&[]; TAPS], count: 0, scale: [0.0; PIXELS] };
        let here = taps.size.index(pixels.start, y);
        for number in 0..TAPS {
            let Some(there) = taps.place(number, pixels.start, y) else { continue };
            let weights = taps.weights(number, here, there, pixels.len());
            piece.scale.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += weight);
            (piece.taps[piece.count], piece.weights[piece.count]) = (there, weights);
            piece.count += 1;
        }
        let scale = |sum: f32| if are_means { 1.0 / sum } else { 1.0 };
        piece.scale[..pixels.len()].iter_mut().for_each(|sum| *sum = scale(*sum));
        piece
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
            let weights = from::<B>(weights, at);
            for p in 0..P {
                let values = from::<B>(planes[p], tap + at);
                for b in 0..B {
                    let weight = Eight::load_some(simd, &weights[b * LANES..]);
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
