//! An à trous kernel that does not cross borders: 5×5 B₃ splines with gaps, times a Gaussian of guide differences
//! (Dammertz et al. 2010).

mod piece;

use std::f32::consts::FRAC_1_SQRT_2;
use std::ops::Range;

use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use stack::{Image, Size};

use super::features::GuideFeatures;
use piece::{PIXELS, PLANES, Piece};

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
        rows.into_par_iter().enumerate().for_each(|(y, smooth)| {
            pulp::Arch::new().dispatch(RowTask { kernel: self, planes: &planes, step, y, smooth });
        });
        smooth
    }
}

/// One row of a picture.
struct RowTask<'a> {
    kernel: &'a GuidedKernel,
    planes: &'a [&'a [f32]],
    step: usize,
    y: usize,
    /// The smooth row, one for each plane.
    smooth: Vec<&'a mut [f32]>,
}

impl WithSimd for RowTask<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { kernel, planes, step, y, mut smooth } = self;
        let mut piece = Piece::new(kernel.size, &kernel.guides, step);
        for pixels in pieces(kernel.size.width, step) {
            piece.weigh(simd, y, pixels.clone());
            for (planes, smooth) in planes.chunks(PLANES).zip(smooth.chunks_mut(PLANES)) {
                match (planes, smooth) {
                    ([a], [x]) => piece.smooth(simd, [a], [&mut x[pixels.clone()]]),
                    ([a, b], [x, y]) => piece.smooth(simd, [a, b], [x, y].map(|row| &mut row[pixels.clone()])),
                    ([a, b, c], [x, y, z]) => {
                        piece.smooth(simd, [a, b, c], [x, y, z].map(|row| &mut row[pixels.clone()]));
                    }
                    _ => {}
                }
            }
        }
    }
}

/// Pieces of a row whose pixels have the same taps in it, none longer than [`PIXELS`].
fn pieces(width: usize, step: usize) -> impl Iterator<Item = Range<usize>> {
    let from_right = |taps: usize| width.saturating_sub(taps * step);
    let mut ends = [step, 2 * step, from_right(2), from_right(1), width].map(|end| end.min(width));
    ends.sort_unstable();
    let mut start = 0;
    ends.into_iter().flat_map(move |end| {
        let all = std::mem::replace(&mut start, end)..end;
        all.step_by(PIXELS).map(move |first| first..(first + PIXELS).min(end))
    })
}

#[cfg(test)]
mod tests;
