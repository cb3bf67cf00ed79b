//! Weighted first and second moments of a window, for the normal equations.

use std::ops::Range;

use pulp::Simd;

use super::row::{FEATURES, Row, WIDTH};
use crate::eight::{Eight, LANES, sum_of_lanes};

/// Pixels that are worked on together: their numbers stay in the innermost cache.
const CHUNK: usize = 128;

/// Rows of the matrix of sums: the weights themselves, and each feature times them.
const ROWS: usize = FEATURES + 1;

/// Sums over the pixels of a window that stand in the same lane.
type Sums = [[[f32; LANES]; WIDTH]; ROWS];

/// Moments about the window's weighted mean, divided by the sum of weights.
#[derive(Clone, Copy, Debug)]
pub struct Moments {
    /// Covariances of each feature with all features and responses.
    pub covariance: [Row; FEATURES],
    /// Weighted mean.
    pub mean: Row,
    /// Sum of weights.
    pub weight: f32,
}

/// Moments of `columns`, the features and then the responses of a window, with one of `weights` for each pixel; all
/// equally long, a multiple of [`LANES`]. Fused multiplications are used on every machine alike.
#[inline(always)]
pub fn moments<S: Simd>(simd: S, columns: &[&[f32]], weights: &[f32]) -> Moments {
    let mut sums = [[[0.0; LANES]; WIDTH]; ROWS];
    let mut weighted = [[0.0; CHUNK]; ROWS];
    let mut total = Eight::splat(simd, 0.0);
    for start in (0..weights.len()).step_by(CHUNK) {
        let chunk = start..(start + CHUNK).min(weights.len());
        for at in (0..chunk.len()).step_by(LANES) {
            let weight = Eight::load(simd, &weights[start + at..]);
            total = total.add(simd, weight);
            weight.store(&mut weighted[0][at..]);
            for j in 0..FEATURES {
                weight.mul(simd, Eight::load(simd, &columns[j][start + at..])).store(&mut weighted[j + 1][at..]);
            }
        }
        add_products::<S, 3>(simd, columns, &chunk, &weighted, 0, &mut sums);
        add_products::<S, 3>(simd, columns, &chunk, &weighted, 3, &mut sums);
        add_products::<S, 3>(simd, columns, &chunk, &weighted, 6, &mut sums);
        add_products::<S, 2>(simd, columns, &chunk, &weighted, 9, &mut sums);
    }
    let mut weight = [0.0; LANES];
    total.store(&mut weight);
    centred(&sums, columns.len(), sum_of_lanes(&weight))
}

/// Adds the products of `R` rows of `weighted`, from number `first` on, with all columns that they have not met in the
/// rows before: the matrix is symmetric.
#[inline(always)]
fn add_products<S: Simd, const R: usize>(
    simd: S,
    columns: &[&[f32]],
    chunk: &Range<usize>,
    weighted: &[[f32; CHUNK]; ROWS],
    first: usize,
    sums: &mut Sums,
) {
    let mut column = first.saturating_sub(1);
    while column < columns.len() {
        let columns = &columns[column..];
        let (weighted, sums) = (&weighted[first..], &mut sums[first..]);
        // As many sums at once as the processor has registers for.
        column += match columns.len() {
            1 => add_block::<S, R, 1>(simd, columns, chunk, weighted, sums, column),
            2 => add_block::<S, R, 2>(simd, columns, chunk, weighted, sums, column),
            3 => add_block::<S, R, 3>(simd, columns, chunk, weighted, sums, column),
            _ => add_block::<S, R, 4>(simd, columns, chunk, weighted, sums, column),
        };
    }
}

/// Adds the products of the first `R` of `weighted` with the first `K` of `columns`; K.
#[inline(always)]
fn add_block<S: Simd, const R: usize, const K: usize>(
    simd: S,
    columns: &[&[f32]],
    chunk: &Range<usize>,
    weighted: &[[f32; CHUNK]],
    sums: &mut [[[f32; LANES]; WIDTH]],
    column: usize,
) -> usize {
    let length = chunk.len();
    let mut from: [&[f32]; K] = [&[]; K];
    for k in 0..K {
        from[k] = &columns[k][chunk.start..chunk.end];
    }
    let mut block = [[Eight::splat(simd, 0.0); K]; R];
    for at in (0..length).step_by(LANES) {
        let mut factors = [Eight::splat(simd, 0.0); R];
        for r in 0..R {
            factors[r] = Eight::load(simd, &weighted[r][at..]);
        }
        for k in 0..K {
            let value = Eight::load(simd, &from[k][at..]);
            for r in 0..R {
                block[r][k] = factors[r].mul_add(simd, value, block[r][k]);
            }
        }
    }
    for r in 0..R {
        for k in 0..K {
            let sum = &mut sums[r][column + k];
            block[r][k].add(simd, Eight::load(simd, sum)).store(sum);
        }
    }
    K
}

/// Sums of products made into covariances.
#[inline(always)]
fn centred(sums: &Sums, columns: usize, weight: f32) -> Moments {
    let scale = 1.0 / weight.max(1e-20);
    let (mut covariance, mut mean) = ([[0.0; WIDTH]; FEATURES], [0.0; WIDTH]);
    for k in 0..columns {
        mean[k] = sum_of_lanes(&sums[0][k]) * scale;
    }
    for j in 0..FEATURES {
        for k in j..columns {
            covariance[j][k] = sum_of_lanes(&sums[j + 1][k]) * scale - mean[j] * mean[k];
            if k < FEATURES {
                covariance[k][j] = covariance[j][k];
            }
        }
    }
    Moments { covariance, mean, weight }
}

#[cfg(test)]
mod tests;
