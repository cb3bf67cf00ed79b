//! Weighted first and second moments of a window, for the normal equations.

use std::ops::Range;

use pulp::Simd;

use super::row::{FEATURES, Row, WIDTH};
use crate::eight::{Eight, LANES, Lanes, sum_of_lanes};

/// Groups of eight pixels that are worked on together: their numbers stay in the innermost cache.
const CHUNK: usize = 16;

/// Rows of the matrix of sums: the weights themselves, and each feature times them.
const ROWS: usize = FEATURES + 1;

/// Buffers that are kept between fits.
#[derive(Debug)]
pub struct Products {
    /// Sums over the pixels of a window that stand in the same lane.
    sums: [[Lanes; WIDTH]; ROWS],
    /// A chunk's weights, and its features times these.
    weighted: [[Lanes; CHUNK]; ROWS],
}

impl Products {
    /// Nothing yet.
    pub fn new() -> Self {
        Self { sums: [[[0.0; LANES]; WIDTH]; ROWS], weighted: [[[0.0; LANES]; CHUNK]; ROWS] }
    }
}

/// Moments about the window's weighted mean, divided by the sum of weights. Responses follow the last feature.
#[derive(Clone, Copy, Debug)]
pub struct Moments {
    /// How many features there are.
    pub features: usize,
    /// Covariances of each feature with all features and responses.
    pub covariance: [Row; FEATURES],
    /// Weighted mean.
    pub mean: Row,
    /// Sum of weights.
    pub weight: f32,
}

impl Products {
    /// Moments of `columns`, so many `features` and then the responses of a window, with one of `weights` for each pixel;
    /// all equally long. Fused multiplications are used on every machine alike.
    #[inline(always)]
    pub fn moments<S: Simd>(&mut self, simd: S, columns: &[&[Lanes]], features: usize, weights: &[Lanes]) -> Moments {
        for row in &mut self.sums[..=features] {
            row[..columns.len()].fill([0.0; LANES]);
        }
        let mut total = Eight::splat(simd, 0.0);
        for start in (0..weights.len()).step_by(CHUNK) {
            let chunk = start..(start + CHUNK).min(weights.len());
            for (at, weight) in weights[chunk.clone()].iter().enumerate() {
                let weight = Eight::of(simd, weight);
                total = total.add(simd, weight);
                self.weighted[0][at] = weight.lanes();
                for j in 0..features {
                    self.weighted[j + 1][at] = weight.mul(simd, Eight::of(simd, &columns[j][start + at])).lanes();
                }
            }
            for first in (0..=features).step_by(3) {
                match features - first {
                    0 => self.add_rows::<S, 1>(simd, columns, &chunk, first),
                    1 => self.add_rows::<S, 2>(simd, columns, &chunk, first),
                    _ => self.add_rows::<S, 3>(simd, columns, &chunk, first),
                }
            }
        }
        centred(&self.sums, columns.len(), features, total.sum())
    }

    /// Adds the products of `R` rows, from number `first` on, with all columns that they have not met in the rows before:
    /// the matrix is symmetric.
    #[inline(always)]
    fn add_rows<S: Simd, const R: usize>(&mut self, simd: S, columns: &[&[Lanes]], chunk: &Range<usize>, first: usize) {
        let mut column = first.saturating_sub(1);
        while column < columns.len() {
            // As many sums at once as the processor has registers for.
            column += match columns.len() - column {
                1 => self.add_block::<S, R, 1>(simd, columns, chunk, first, column),
                2 => self.add_block::<S, R, 2>(simd, columns, chunk, first, column),
                3 => self.add_block::<S, R, 3>(simd, columns, chunk, first, column),
                _ => self.add_block::<S, R, 4>(simd, columns, chunk, first, column),
            };
        }
    }

    /// Adds the products of `R` rows from number `first` on with `K` columns from number `column` on; `K`.
    #[inline(always)]
    fn add_block<S: Simd, const R: usize, const K: usize>(
        &mut self,
        simd: S,
        columns: &[&[Lanes]],
        chunk: &Range<usize>,
        first: usize,
        column: usize,
    ) -> usize {
        let length = chunk.len();
        let (mut rows, mut from): ([&[Lanes]; R], [&[Lanes]; K]) = ([&[]; R], [&[]; K]);
        for r in 0..R {
            rows[r] = &self.weighted[first + r][..length];
        }
        for k in 0..K {
            from[k] = &columns[column + k][chunk.start..][..length];
        }
        let mut block = [[Eight::splat(simd, 0.0); K]; R];
        for at in 0..length {
            let mut factors = [Eight::splat(simd, 0.0); R];
            for r in 0..R {
                factors[r] = Eight::of(simd, &rows[r][at]);
            }
            for k in 0..K {
                let value = Eight::of(simd, &from[k][at]);
                for r in 0..R {
                    block[r][k] = factors[r].mul_add(simd, value, block[r][k]);
                }
            }
        }
        for r in 0..R {
            for k in 0..K {
                let sum = &mut self.sums[first + r][column + k];
                *sum = block[r][k].add(simd, Eight::of(simd, sum)).lanes();
            }
        }
        K
    }
}

/// Sums of products made into covariances.
#[inline(always)]
fn centred(sums: &[[Lanes; WIDTH]; ROWS], columns: usize, features: usize, weight: f32) -> Moments {
    let scale = 1.0 / weight.max(1e-20);
    let (mut covariance, mut mean) = ([[0.0; WIDTH]; FEATURES], [0.0; WIDTH]);
    for k in 0..columns {
        mean[k] = sum_of_lanes(&sums[0][k]) * scale;
    }
    for j in 0..features {
        for k in j..columns {
            covariance[j][k] = sum_of_lanes(&sums[j + 1][k]) * scale - mean[j] * mean[k];
            if k < features {
                covariance[k][j] = covariance[j][k];
            }
        }
    }
    Moments { features, covariance, mean, weight }
}

#[cfg(test)]
pub mod tests;
