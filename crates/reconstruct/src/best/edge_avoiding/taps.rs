//! What the taps of all pixels weigh.

use std::ops::Range;

use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use stack::{Size, planes_of_zeros};

use crate::eight::{Eight, LANES};
use crate::exp::exp_of_negative;

/// The B₃ spline.
const SPLINE: [f32; 5] = [0.0625, 0.25, 0.375, 0.25, 0.0625];
/// Taps along a side and in all.
pub const SIDE: usize = SPLINE.len();
pub const TAPS: usize = SIDE * SIDE;
/// The tap in the middle; half of the others lie behind it in the order of rows.
pub const MIDDLE: usize = TAPS / 2;

/// Most pixels whose taps are looked at together: what that reads stays in the innermost cache.
pub const PIXELS: usize = 128;
/// Pixels (times eight) whose taps are weighed side by side.
const BATCHES: usize = 4;

/// A kernel with gaps. Two pixels weigh the same for each other, so only the taps behind a pixel are kept.
pub struct Taps {
    pub size: Size,
    /// Pixels from tap to tap.
    pub step: usize,
    /// A plane for each tap behind the middle; zero where it lies outside the picture.
    pub(super) weights: Vec<Vec<f32>>,
}

/// What separates pixels.
pub struct Separation<'a> {
    /// Planes of the picture's size.
    pub planes: Vec<&'a [f32]>,
    /// A weight is exp(−`per_square` Σ Δ²).
    pub per_square: f32,
}

impl Taps {
    /// Taps `step` pixels apart in a picture of `size` whose pixels are told apart by `separation`.
    pub fn weighed(size: Size, separation: &Separation, step: usize) -> Self {
        let mut weights = planes_of_zeros(size.pixels(), MIDDLE);
        for_each_row(&mut weights, size.width, |y, weights| {
            pulp::Arch::new().dispatch(WeightTask { size, separation, step, y, weights });
        });
        Self { size, step, weights }
    }

    /// Where tap `number` of the pixel in column `x`, row `y` lies, if it does in the picture.
    #[inline(always)]
    pub fn place(&self, number: usize, x: usize, y: usize) -> Option<usize> {
        let tap = |from: usize, number: usize| (from + number * self.step).checked_sub(SIDE / 2 * self.step);
        let row = tap(y, number / SIDE).filter(|row| *row < self.size.height)?;
        let column = tap(x, number % SIDE).filter(|column| *column < self.size.width)?;
        Some(self.size.index(column, row))
    }

    /// Weights of tap `number`, which lies at `there`, of `count` pixels from `here` on.
    #[inline(always)]
    pub fn weights(&self, number: usize, here: usize, there: usize, count: usize) -> &[f32] {
        match number.checked_sub(MIDDLE + 1) {
            Some(behind) => &self.weights[behind][here..][..count],
            None if number == MIDDLE => &OF_MIDDLE[..count],
            None => &self.weights[MIDDLE - 1 - number][there..][..count],
        }
    }
}

/// What pixels weigh for themselves.
const OF_MIDDLE: &[f32; PIXELS] = &[SPLINE[SIDE / 2] * SPLINE[SIDE / 2]; PIXELS];

/// Works on all `planes` row by row, on all threads.
pub fn for_each_row(planes: &mut [Vec<f32>], width: usize, work: impl Fn(usize, Vec<&mut [f32]>) + Sync) {
    if width == 0 {
        return;
    }
    let height = planes.first().map_or(0, |plane| plane.len() / width);
    let mut rows: Vec<_> = planes.iter_mut().map(|plane| plane.chunks_exact_mut(width)).collect();
    let rows: Vec<Vec<&mut [f32]>> =
        (0..height).map(|_| rows.iter_mut().filter_map(Iterator::next).collect()).collect();
    rows.into_par_iter().enumerate().for_each(|(y, rows)| work(y, rows));
}

/// Which of these `columns` of row `y` have tap `number`, one behind the middle, in the picture, and where the first one's
/// lies.
#[inline(always)]
pub fn columns_with(
    number: usize,
    size: Size,
    step: usize,
    y: usize,
    columns: Range<usize>,
) -> Option<(Range<usize>, usize)> {
    let [across, down] = [number % SIDE, number / SIDE];
    let row = y + (down - SIDE / 2) * step;
    let (left, right) = ((SIDE / 2).saturating_sub(across) * step, across.saturating_sub(SIDE / 2) * step);
    let inside = columns.start.max(left)..columns.end.min(size.width.saturating_sub(right));
    if row >= size.height || inside.is_empty() {
        return None;
    }
    let there = size.index(inside.start + right - left, row);
    Some((inside, there))
}

/// Weights of one row.
struct WeightTask<'a> {
    size: Size,
    separation: &'a Separation<'a>,
    step: usize,
    y: usize,
    /// The row, once for each tap behind the middle.
    weights: Vec<&'a mut [f32]>,
}

impl WithSimd for WeightTask<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { size, separation, step, y, mut weights } = self;
        for first in (0..size.width).step_by(PIXELS) {
            let all = first..(first + PIXELS).min(size.width);
            for (behind, weights) in weights.iter_mut().enumerate() {
                let number = MIDDLE + 1 + behind;
                let Some((inside, there)) = columns_with(number, size, step, y, all.clone()) else { continue };
                let here = size.index(inside.start, y);
                let weights = &mut weights[inside];
                squares(simd, &separation.planes, here, there, weights);
                let spline = SPLINE[number / SIDE] * SPLINE[number % SIDE];
                weights.iter_mut().for_each(|w| *w = spline * exp_of_negative(-separation.per_square * *w));
            }
        }
    }
}

/// Σ Δ² between consecutive pixels from number `here` on and those from `there` on.
#[inline(always)]
fn squares<S: Simd>(simd: S, planes: &[&[f32]], here: usize, there: usize, out: &mut [f32]) {
    let mut at = 0;
    while at + BATCHES * LANES <= out.len() {
        squares_of::<S, BATCHES>(simd, planes, here + at, there + at, &mut out[at..][..BATCHES * LANES]);
        at += BATCHES * LANES;
    }
    for at in (at..out.len()).step_by(LANES) {
        let count = LANES.min(out.len() - at);
        squares_of::<S, 1>(simd, planes, here + at, there + at, &mut out[at..][..count]);
    }
}

/// The same of `B` times eight pixels, or fewer if `B` is one.
#[inline(always)]
fn squares_of<S: Simd, const B: usize>(simd: S, planes: &[&[f32]], here: usize, there: usize, out: &mut [f32]) {
    let (count, mut sums) = (out.len(), [Eight::splat(simd, 0.0); B]);
    for plane in planes {
        let (p, q) = (&plane[here..][..count], &plane[there..][..count]);
        for b in 0..B {
            let here = Eight::load_some(simd, &p[b * LANES..]);
            let difference = here.sub(simd, Eight::load_some(simd, &q[b * LANES..]));
            sums[b] = difference.mul_add(simd, difference, sums[b]);
        }
    }
    for b in 0..B {
        sums[b].store_some(&mut out[b * LANES..]);
    }
}
