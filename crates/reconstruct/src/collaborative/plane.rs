//! A linear fit: the responses as a plane over the features.

use pulp::Simd;

use super::moments::Moments;
use super::row::FEATURES;
use crate::eight::{Eight, Lanes};

/// Responses, padded to what processors take at once.
pub const PADDED: usize = 8;

/// A number for each response; the places past the responses are free.
type Padded = [f32; PADDED];

/// Responses that are predicted together, and groups of eight pixels: as many as the processor has registers for.
const TOGETHER: usize = 3;
const BATCH: usize = 4;

/// Responses as a linear function of features relative to the centre of the fit.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// Prediction at the centre.
    intercept: Padded,
    slopes: [Padded; FEATURES],
    features: usize,
}

impl Plane {
    /// Solves the normal equations of `moments` with `ridge` added to the variance of every feature, by Cholesky's
    /// decomposition. Moments are relative to the centre, whose responses are `centre`.
    #[inline(always)]
    pub fn fitted<S: Simd>(simd: S, moments: &Moments, ridge: f32, centre: &[f32]) -> Self {
        let mut matrix = [[0.0; FEATURES]; FEATURES];
        let mut slopes = [[0.0; PADDED]; FEATURES];
        let (features, responses) = (moments.features, centre.len());
        for j in 0..features {
            matrix[j][..=j].copy_from_slice(&moments.covariance[j][..=j]);
            matrix[j][j] = matrix[j][j].max(0.0) + ridge;
            slopes[j][..responses].copy_from_slice(&moments.covariance[j][features..features + responses]);
        }
        decompose(&mut matrix[..features]);
        solve(simd, &matrix, &mut slopes[..features]);
        let mut intercept = [0.0; PADDED];
        for c in 0..responses {
            intercept[c] = centre[c] + moments.mean[features + c];
        }
        for j in 0..features {
            add_multiple(simd, &mut intercept, -moments.mean[j], &slopes[j]);
        }
        Self { intercept, slopes, features }
    }

    /// The responses at pixels whose features, relative to the centre, are the first of `columns`, times `weights`: one
    /// list after the other in `out`, all equally long.
    #[inline(always)]
    pub fn predict<S: Simd>(
        &self,
        simd: S,
        columns: &[&[Lanes]],
        weights: &[Lanes],
        responses: usize,
        out: &mut [Lanes],
    ) {
        let length = weights.len();
        for first in (0..responses).step_by(TOGETHER) {
            let out = &mut out[first * length..][..TOGETHER * length];
            let mut at = 0;
            while at < length {
                at += match length - at {
                    1 => self.predict_batch::<S, 1>(simd, columns, weights, first, at, out),
                    2 => self.predict_batch::<S, 2>(simd, columns, weights, first, at, out),
                    3 => self.predict_batch::<S, 3>(simd, columns, weights, first, at, out),
                    _ => self.predict_batch::<S, BATCH>(simd, columns, weights, first, at, out),
                };
            }
        }
    }

    /// Some responses of `B` groups of eight pixels, from number `at` on; `B`.
    #[inline(always)]
    fn predict_batch<S: Simd, const B: usize>(
        &self,
        simd: S,
        columns: &[&[Lanes]],
        weights: &[Lanes],
        first: usize,
        at: usize,
        out: &mut [Lanes],
    ) -> usize {
        let mut sums = [[Eight::splat(simd, 0.0); B]; TOGETHER];
        for c in 0..TOGETHER {
            sums[c] = [Eight::splat(simd, self.intercept[first + c]); B];
        }
        for (column, slopes) in columns.iter().zip(&self.slopes[..self.features]) {
            let feature = &column[at..][..B];
            let mut values = [Eight::splat(simd, 0.0); B];
            for b in 0..B {
                values[b] = Eight::of(simd, &feature[b]);
            }
            for c in 0..TOGETHER {
                let slope = Eight::splat(simd, slopes[first + c]);
                for b in 0..B {
                    sums[c][b] = slope.mul_add(simd, values[b], sums[c][b]);
                }
            }
        }
        for b in 0..B {
            let weight = Eight::of(simd, &weights[at + b]);
            for c in 0..TOGETHER {
                out[c * weights.len() + at + b] = weight.mul(simd, sums[c][b]).lanes();
            }
        }
        B
    }
}

/// Lower Cholesky factor of a symmetric positive matrix, in place; its diagonal as reciprocals.
#[inline(always)]
fn decompose(matrix: &mut [[f32; FEATURES]]) {
    for j in 0..matrix.len() {
        for l in 0..=j {
            let mut value = matrix[j][l];
            for m in 0..l {
                value -= matrix[j][m] * matrix[l][m];
            }
            matrix[j][l] = if j == l { 1.0 / value.max(1e-9).sqrt() } else { value * matrix[l][l] };
        }
    }
}

/// Solves L Lᵀ x = b for all responses side by side.
#[inline(always)]
fn solve<S: Simd>(simd: S, factor: &[[f32; FEATURES]; FEATURES], b: &mut [Padded]) {
    for j in 0..b.len() {
        let (solved, rest) = b.split_at_mut(j);
        for (m, row) in solved.iter().enumerate() {
            add_multiple(simd, &mut rest[0], -factor[j][m], row);
        }
        rest[0].iter_mut().for_each(|v| *v *= factor[j][j]);
    }
    for j in (0..b.len()).rev() {
        let (rest, solved) = b.split_at_mut(j + 1);
        for (m, row) in solved.iter().enumerate() {
            add_multiple(simd, &mut rest[j], -factor[j + 1 + m][j], row);
        }
        rest[j].iter_mut().for_each(|v| *v *= factor[j][j]);
    }
}

/// `sum` + `factor` · `values`.
#[inline(always)]
fn add_multiple<S: Simd>(simd: S, sum: &mut Padded, factor: f32, values: &Padded) {
    let sums = S::as_mut_simd_f32s(sum).0;
    for (sum, value) in sums.iter_mut().zip(S::as_simd_f32s(values).0) {
        *sum = simd.mul_add_f32s(simd.splat_f32s(factor), *value, *sum);
    }
}

#[cfg(test)]
mod tests;
