//! The cross-bilateral filter of one row, and how its result follows the bandwidths.

use super::kernel::{Bandwidths, RowKernel, TERMS, offsets, precisions};
use super::primary::Primary;

/// Filters row `y` of a picture, with bandwidths of their own for each of its pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowFilter<'a> {
    pub(super) primary: &'a Primary,
    /// Radius of the window.
    pub(super) radius: usize,
    pub(super) y: usize,
    /// A value per column.
    pub(super) bandwidths: &'a [Bandwidths],
}

/// A filtered row.
#[derive(Clone, Debug)]
pub(super) struct FilteredRow {
    /// ĉ, per channel.
    pub(super) colour: [Vec<f32>; 3],
    /// W = Σ w, the pixel's own weight being 1.
    pub(super) weight: Vec<f32>,
    /// Variance of ĉ if the weights were no matter of chance: Σ w² v/W².
    pub(super) variance: Vec<f32>,
}

impl pulp::NullaryFnOnce for RowFilter<'_> {
    type Output = FilteredRow;

    #[inline(always)]
    fn call(self) -> FilteredRow {
        let width = self.primary.size.width;
        let [r, g, b, v] = std::array::from_fn(|_| vec![0.0; width]);
        let mut sums = FilteredRow { colour: [r, g, b], weight: vec![0.0; width], variance: v };
        let (precisions, mut kernel) = (precisions(self.bandwidths), RowKernel::default());
        for offset in offsets(self.y, self.primary.size.height, self.radius) {
            kernel.compute(self.primary, self.y, offset, &precisions);
            self.add(&kernel, offset, &mut sums);
        }
        for (i, weight) in sums.weight.iter().enumerate() {
            sums.colour.iter_mut().for_each(|sum| sum[i] /= weight);
            sums.variance[i] /= weight * weight;
        }
        sums
    }
}

impl RowFilter<'_> {
    /// The first neighbour of `columns` at `offset`.
    #[inline(always)]
    fn neighbours(&self, kernel: &RowKernel, [dx, dy]: [isize; 2]) -> usize {
        let width = self.primary.size.width;
        (self.y * width + kernel.columns.start).wrapping_add_signed(dx + dy * width as isize)
    }

    #[inline(always)]
    fn add(&self, kernel: &RowKernel, offset: [isize; 2], sums: &mut FilteredRow) {
        let (there, count) = (self.neighbours(kernel, offset), kernel.columns.len());
        for (sum, plane) in sums.colour.iter_mut().zip(&self.primary.colour) {
            let (sum, plane) = (&mut sum[kernel.columns.clone()], &plane[there..][..count]);
            sum.iter_mut().zip(&kernel.weights).zip(plane).for_each(|((sum, w), c)| *sum += w * c);
        }
        let weight = &mut sums.weight[kernel.columns.clone()];
        weight.iter_mut().zip(&kernel.weights).for_each(|(sum, w)| *sum += w);
        let noise = &self.primary.colour_variance[there..][..count];
        let variance = &mut sums.variance[kernel.columns.clone()];
        variance.iter_mut().zip(&kernel.weights).zip(noise).for_each(|((sum, w), v)| *sum += w * w * v);
    }
}

/// dE/dγ of a row, from dE/dĉ of its pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowGradient<'a> {
    pub(super) filter: RowFilter<'a>,
    pub(super) filtered: &'a FilteredRow,
    /// dE/dĉ, per channel.
    pub(super) slope: &'a [Vec<f32>; 3],
}

impl pulp::NullaryFnOnce for RowGradient<'_> {
    /// dE/dγ, a value per column.
    type Output = Vec<Bandwidths>;

    /// From ĉ = Σ w c/W and w = exp(−Σ Δ/(2γ²)): dE/dγ = Σ w (Δ/γ³) (dE/dĉ)·(c − ĉ)/W.
    #[inline(always)]
    fn call(self) -> Self::Output {
        let RowFilter { primary, radius, y, bandwidths } = self.filter;
        let (precisions, mut kernel) = (precisions(bandwidths), RowKernel::default());
        let mut sums: [Vec<f32>; TERMS] = std::array::from_fn(|_| vec![0.0; primary.size.width]);
        let mut pull = Vec::new();
        for offset in offsets(y, primary.size.height, radius) {
            kernel.compute(primary, y, offset, &precisions);
            self.pull_of(&kernel, offset, &mut pull);
            for (sums, distances) in sums.iter_mut().zip(&kernel.distances) {
                let sums = &mut sums[kernel.columns.clone()];
                sums.iter_mut().zip(&pull).zip(distances).for_each(|((sum, pull), d)| *sum += pull * d);
            }
        }
        let of = |x: usize| {
            let scale = |term: usize| sums[term][x] / (self.filtered.weight[x] * bandwidths[x][term].powi(3));
            std::array::from_fn(scale)
        };
        (0..primary.size.width).map(of).collect()
    }
}

impl RowGradient<'_> {
    /// w (dE/dĉ)·(c − ĉ) of every neighbour at `offset`.
    #[inline(always)]
    fn pull_of(&self, kernel: &RowKernel, offset: [isize; 2], pull: &mut Vec<f32>) {
        let (there, count) = (self.filter.neighbours(kernel, offset), kernel.columns.len());
        pull.clear();
        pull.resize(count, 0.0);
        for c in 0..3 {
            let plane = &self.filter.primary.colour[c][there..][..count];
            let filtered = &self.filtered.colour[c][kernel.columns.clone()];
            let slope = &self.slope[c][kernel.columns.clone()];
            for i in 0..count {
                pull[i] += slope[i] * (plane[i] - filtered[i]);
            }
        }
        pull.iter_mut().zip(&kernel.weights).for_each(|(pull, w)| *pull *= w);
    }
}
