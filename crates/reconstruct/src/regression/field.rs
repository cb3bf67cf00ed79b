//! The input of a regression, laid out so that any window of it is read in whole vectors.

use pulp::Simd;
use stack::Size;

use super::RegressionInput;
use super::lanes::{Lanes, MOST_LANES};

/// Features are promised within [−1, 1]; a stray value beyond this bound is drawn in, so that no square overflows.
const LARGEST_FEATURE: f32 = 1e4;

/// All planes of the input. Each row is framed by copies of its outermost pixels, wide enough that the windows of the
/// pixels worked on side by side never leave it.
#[derive(Debug)]
pub(crate) struct Field {
    pub(crate) size: Size,
    pub(crate) radius: usize,
    /// Number of features.
    pub(crate) features: usize,
    /// First feature and end of each group.
    pub(crate) groups: Vec<std::ops::Range<usize>>,
    stride: usize,
    values: Vec<f32>,
}

impl Field {
    /// Frames the planes of `input` for windows of `radius`.
    pub(crate) fn new(input: &RegressionInput, radius: usize) -> Self {
        let size = input.features.size;
        let stride = size.width + Self::columns_of(radius) + MOST_LANES;
        let features = &input.features.planes;
        let mut field = Self {
            size,
            radius,
            features: features.len(),
            groups: input.features.groups.clone(),
            stride,
            values: vec![0.0; stride * size.height * (features.len() + 6)],
        };
        let bounded = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(-LARGEST_FEATURE, LARGEST_FEATURE) };
        for (plane, values) in features.iter().enumerate() {
            field.fill(plane, values, bounded);
        }
        for c in 0..3 {
            field.fill(features.len() + c, &input.colour.channels()[c], |x| x);
            field.fill(features.len() + 3 + c, &input.variance.channels()[c], |x| x);
        }
        field
    }

    fn fill(&mut self, plane: usize, from: &[f32], value: impl Fn(f32) -> f32) {
        for (y, row) in from.chunks_exact(self.size.width.max(1)).enumerate() {
            let start = self.start_of(plane, y);
            for (x, to) in self.values[start..start + self.stride].iter_mut().enumerate() {
                *to = value(row[x.saturating_sub(self.radius).min(row.len() - 1)]);
            }
        }
    }

    fn start_of(&self, plane: usize, y: usize) -> usize {
        (plane * self.size.height + y) * self.stride
    }

    /// Columns of a window, rounded up to what matrix kernels want; the last ones are never inside.
    pub(crate) fn columns(&self) -> usize {
        Self::columns_of(self.radius)
    }

    const fn columns_of(radius: usize) -> usize {
        (2 * radius + 1).next_multiple_of(4)
    }

    /// The part of row `y` of `plane` that starts `radius` pixels left of pixel `x`: window column c of the pixels
    /// worked on side by side starts at its element c.
    #[inline(always)]
    pub(crate) fn row(&self, plane: usize, x: usize, y: usize) -> &[f32] {
        let start = self.start_of(plane, y) + x;
        &self.values[start..start + self.columns() + MOST_LANES - 1]
    }

    /// Values of `plane` at pixels x, x + 1, … of row `y`.
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, plane: usize, x: usize, y: usize) -> Lanes<S> {
        Lanes::load(simd, &self.row(plane, x, y)[self.radius..])
    }

    /// Index of the plane of colour channel `channel`.
    pub(crate) const fn colour(&self, channel: usize) -> usize {
        self.features + channel
    }

    /// Index of the plane of the variance of colour channel `channel`.
    pub(crate) const fn variance(&self, channel: usize) -> usize {
        self.features + 3 + channel
    }
}
