//! Planes smoothed by weighed taps.

use std::ops::Range;

use pulp::{Simd, WithSimd};
use stack::planes_of_zeros;

use super::piece::{PLANES, Piece};
use super::taps::{PIXELS, Taps, for_each_row};

impl Taps {
    /// Smooths `planes`: weighed means.
    pub fn smooth(&self, planes: &[impl AsRef<[f32]>]) -> Vec<Vec<f32>> {
        let planes: Vec<&[f32]> = planes.iter().map(AsRef::as_ref).collect();
        self.sums(&planes, true)
    }

    /// Weighed sums of a plane's values: the spline's sum is one, what lies elsewhere counts as zero.
    pub fn sum(&self, plane: &[f32]) -> Vec<f32> {
        self.sums(&[plane], false).remove(0)
    }

    /// Weighed sums of `planes`, perhaps over the sum of the weights.
    fn sums(&self, planes: &[&[f32]], are_means: bool) -> Vec<Vec<f32>> {
        let mut sums = planes_of_zeros(self.size.pixels(), planes.len());
        for_each_row(&mut sums, self.size.width, |y, sums| {
            pulp::Arch::new().dispatch(RowTask { taps: self, planes, are_means, y, sums });
        });
        sums
    }
}

/// One row of a picture.
struct RowTask<'a> {
    taps: &'a Taps,
    planes: &'a [&'a [f32]],
    /// Whether sums are over that of the weights.
    are_means: bool,
    y: usize,
    /// The row of sums, one for each plane.
    sums: Vec<&'a mut [f32]>,
}

impl WithSimd for RowTask<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { taps, planes, are_means, y, mut sums } = self;
        for pixels in pieces(taps.size.width, taps.step) {
            let piece = Piece::new(taps, y, pixels.clone(), are_means);
            for (planes, sums) in planes.chunks(PLANES).zip(sums.chunks_mut(PLANES)) {
                match (planes, sums) {
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
