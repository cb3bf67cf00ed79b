//! An à trous kernel that does not cross borders: 5×5 B₃ splines with gaps, times a Gaussian of guide differences
//! (Dammertz et al. 2010).

use rayon::prelude::*;
use stack::{Image, Size};
use std::f32::consts::FRAC_1_SQRT_2;

use super::features::GuideFeatures;
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
    pub fn smooth(&self, planes: &[Vec<f32>], step: usize) -> Vec<Vec<f32>> {
        let rows: Vec<Vec<Vec<f32>>> = (0..self.size.height)
            .into_par_iter()
            .map(|y| pulp::Arch::new().dispatch(RowTask { kernel: self, planes, step: step as isize, y }))
            .collect();
        let plane = |p: usize| rows.iter().flat_map(|row| row[p].iter().copied()).collect();
        (0..planes.len()).map(plane).collect()
    }

    /// Weights of consecutive pixels from `there` for those from `here`.
    #[inline(always)]
    fn weigh(&self, here: usize, there: usize, spline: f32, weights: &mut [f32]) {
        let count = weights.len();
        weights.fill(0.0);
        for guide in &self.guides {
            let (p, q) = (&guide[here..][..count], &guide[there..][..count]);
            for ((weight, p), q) in weights.iter_mut().zip(p).zip(q) {
                *weight += (p - q) * (p - q);
            }
        }
        weights.iter_mut().for_each(|w| *w = spline * exp_of_negative(-*w));
    }
}

/// One row of a picture.
struct RowTask<'a> {
    kernel: &'a GuidedKernel,
    planes: &'a [Vec<f32>],
    step: isize,
    y: usize,
}

impl pulp::NullaryFnOnce for RowTask<'_> {
    type Output = Vec<Vec<f32>>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let Self { kernel, planes, step, y } = self;
        let width = kernel.size.width;
        let mut sums = vec![vec![0.0; width]; planes.len()];
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
                kernel.weigh(here, there, across * along, weights);
                norm[from..to].iter_mut().zip(&*weights).for_each(|(sum, w)| *sum += w);
                for (sums, plane) in sums.iter_mut().zip(planes) {
                    let values = &plane[there..][..weights.len()];
                    for ((sum, w), value) in sums[from..to].iter_mut().zip(&*weights).zip(values) {
                        *sum += w * value;
                    }
                }
            }
        }
        for sums in &mut sums {
            sums.iter_mut().zip(&norm).for_each(|(sum, norm)| *sum /= norm);
        }
        sums
    }
}

#[cfg(test)]
mod tests;
