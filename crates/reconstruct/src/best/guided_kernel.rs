//! An à trous kernel that does not cross borders: 5×5 B₃ splines with gaps, times a Gaussian of guide differences
//! (Dammertz et al. 2010).

use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use stack::{Image, Size};
use std::f32::consts::FRAC_1_SQRT_2;

use super::features::GuideFeatures;
use crate::eight::{Eight, LANES};
use crate::exp::exp_of_negative;

/// The B₃ spline.
const SPLINE: [f32; 5] = [0.0625, 0.25, 0.375, 0.25, 0.0625];

/// Planes whose differences separate pixels: a weight is exp(−Σ Δ²).
#[derive(Clone, Debug)]
pub struct GuidedKernel {
    size: Size,
    guides: Vec<Vec<f32>>,
}

impl GuidedKernel {
    /// A kernel for an image of `size`, guided by planes that are scaled already.
    pub fn new(size: Size, guides: Vec<Vec<f32>>) -> Self {
        Self { size, guides }
    }

    /// A kernel that stays on surfaces: features that differ by `scale` or more are kept apart.
    pub fn surfaces(features: &GuideFeatures, scale: f32) -> Self {
        Self::new(features.set.size, features.scaled_surfaces(FRAC_1_SQRT_2 / scale))
    }

    /// A kernel that stays on surfaces and among pixels of like brightness in `picture`: a squared difference of its
    /// logarithm counts `brightness` times one of a feature.
    pub fn surfaces_and_brightness(features: &GuideFeatures, picture: &Image, scale: f32, brightness: f32) -> Self {
        let mut kernel = Self::surfaces(features, scale);
        let factor = FRAC_1_SQRT_2 / scale * brightness.sqrt();
        let logarithm = |v: &f32| factor * (v + 0.02).max(0.01).ln();
        kernel.guides.extend(picture.channels().iter().map(|plane| plane.iter().map(logarithm).collect()));
        kernel
    }

    /// Smooths `planes` with taps `step` pixels apart.
    pub fn smooth(&self, planes: &[impl AsRef<[f32]>], step: usize) -> Vec<Vec<f32>> {
        let planes: Vec<&[f32]> = planes.iter().map(AsRef::as_ref).collect();
        let mut smooth = vec![vec![0.0; self.size.pixels()]; planes.len()];
        if self.size.width == 0 {
            return smooth;
        }
        let mut rows: Vec<_> = smooth.iter_mut().map(|plane| plane.chunks_exact_mut(self.size.width)).collect();
        let rows: Vec<Vec<&mut [f32]>> =
            (0..self.size.height).map(|_| rows.iter_mut().filter_map(Iterator::next).collect()).collect();
        rows.into_par_iter().enumerate().for_each(|(y, sums)| {
            pulp::Arch::new().dispatch(RowTask { kernel: self, planes: &planes, step: step as isize, y, sums });
        });
        smooth
    }

    /// Weights of consecutive pixels from `there` for those from `here`.
    #[inline(always)]
    fn weigh<S: Simd>(&self, simd: S, here: usize, there: usize, spline: f32, weights: &mut [f32]) {
        let count = weights.len();
        let (whole, batches) = (count / LANES * LANES, count / (BATCH * LANES) * (BATCH * LANES));
        for at in (0..batches).step_by(BATCH * LANES) {
            self.squares::<S, BATCH>(simd, here + at, there + at, &mut weights[at..]);
        }
        for at in (batches..whole).step_by(LANES) {
            self.squares::<S, 1>(simd, here + at, there + at, &mut weights[at..]);
        }
        for at in whole..count {
            weights[at] = 0.0;
            for guide in &self.guides {
                let difference = guide[here + at] - guide[there + at];
                weights[at] = difference.mul_add(difference, weights[at]);
            }
        }
        for weight in weights {
            *weight = spline * exp_of_negative(-*weight);
        }
    }

    /// Σ Δ² of `B` times eight pixels.
    #[inline(always)]
    fn squares<S: Simd, const B: usize>(&self, simd: S, here: usize, there: usize, squares: &mut [f32]) {
        let mut sums = [Eight::splat(simd, 0.0); B];
        for guide in &self.guides {
            let (p, q) = (&guide[here..][..B * LANES], &guide[there..][..B * LANES]);
            for b in 0..B {
                let difference = Eight::load(simd, &p[b * LANES..]).sub(simd, Eight::load(simd, &q[b * LANES..]));
                sums[b] = difference.mul_add(simd, difference, sums[b]);
            }
        }
        for b in 0..B {
            sums[b].store(&mut squares[b * LANES..]);
        }
    }
}

/// How many times eight pixels are weighed together.
const BATCH: usize = 4;

/// One row of a picture.
struct RowTask<'a> {
    kernel: &'a GuidedKernel,
    planes: &'a [&'a [f32]],
    step: isize,
    y: usize,
    /// The smooth row, one for each plane; zeros at first.
    sums: Vec<&'a mut [f32]>,
}

impl WithSimd for RowTask<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { kernel, planes, step, y, mut sums } = self;
        let width = kernel.size.width;
        let (mut norm, mut weights) = (vec![0.0; width], vec![0.0; width]);
        for (j, across) in SPLINE.iter().enumerate() {
            let Some(row) = y.checked_add_signed((j as isize - 2) * step).filter(|row| *row < kernel.size.height)
            else {
                continue;
            };
            for (i, along) in SPLINE.iter().enumerate() {
                let dx = (i as isize - 2) * step;
                let from = (-dx).max(0) as usize;
                let to = width.saturating_sub(dx.max(0) as usize);
                if from >= to {
                    continue;
                }
                let here = kernel.size.index(from, y);
                let there = kernel.size.index(from.wrapping_add_signed(dx), row);
                let weights = &mut weights[from..to];
                kernel.weigh(simd, here, there, across * along, weights);
                add(&mut norm[from..to], weights);
                for p in 0..planes.len() {
                    add_products(&mut sums[p][from..to], weights, &planes[p][there..]);
                }
            }
        }
        for sums in &mut sums {
            for x in 0..width {
                sums[x] /= norm[x];
            }
        }
    }
}

#[inline(always)]
fn add(sums: &mut [f32], values: &[f32]) {
    let values = &values[..sums.len()];
    for i in 0..sums.len() {
        sums[i] += values[i];
    }
}

#[inline(always)]
fn add_products(sums: &mut [f32], weights: &[f32], values: &[f32]) {
    let (weights, values) = (&weights[..sums.len()], &values[..sums.len()]);
    for i in 0..sums.len() {
        sums[i] += weights[i] * values[i];
    }
}

#[cfg(test)]
mod tests;
