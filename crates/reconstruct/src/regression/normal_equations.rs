//! Weighted least squares: rows are collected a few at a time and added to the normal equations in one go.

use pulp::Simd;

use super::lanes::Lanes;
use super::matrix::add_gram;

/// Rows collected before they are added: few enough to stay in the nearest cache.
const BLOCK: usize = 16;

/// The normal matrix XᵀX of rows that come one by one.
#[derive(Debug)]
pub(crate) struct NormalEquations<S: Simd> {
    simd: S,
    /// Numbers per row, even.
    pub(crate) width: usize,
    /// The matrix, `width` × `width`; its upper triangle counts.
    pub(crate) matrix: Vec<Lanes<S>>,
    rows: Vec<Lanes<S>>,
    filled: usize,
}

impl<S: Simd> NormalEquations<S> {
    /// Room for rows of up to `most` numbers.
    pub(crate) fn with_capacity(simd: S, most: usize) -> Self {
        let zeros = |n| vec![Lanes::splat(simd, 0.0); n];
        Self { simd, width: 0, matrix: zeros(most * most), rows: zeros(BLOCK * most), filled: 0 }
    }

    /// Starts with no rows of `width` numbers, an even count.
    #[inline(always)]
    pub(crate) fn begin(&mut self, width: usize) {
        self.width = width;
        self.filled = 0;
        self.matrix[..width * width].fill(Lanes::splat(self.simd, 0.0));
    }

    /// A row to be written: the square root of its weight times its numbers. Holds anything until then.
    #[inline(always)]
    pub(crate) fn next_row(&mut self) -> &mut [Lanes<S>] {
        if self.filled == BLOCK {
            self.finish();
        }
        self.filled += 1;
        &mut self.rows[(self.filled - 1) * self.width..][..self.width]
    }

    /// Adds the rows still waiting.
    #[inline(always)]
    pub(crate) fn finish(&mut self) {
        let width = self.width;
        add_gram(self.simd, &mut self.matrix[..width * width], &self.rows[..self.filled * width], width);
        self.filled = 0;
    }

    /// Adds `ridge` to the diagonal entries of `unknowns`.
    #[inline(always)]
    pub(crate) fn add_ridge(&mut self, unknowns: std::ops::Range<usize>, ridge: Lanes<S>) {
        for i in unknowns {
            self.matrix[i * self.width + i] += ridge;
        }
    }
}
