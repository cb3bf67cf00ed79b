//! A linear fit: the responses as a plane over the features.

use pulp::Simd;

use super::moments::Moments;
use super::row::{FEATURES, RESPONSES, Row};

/// Responses, padded to what processors take at once.
pub const PADDED: usize = 8;

/// Responses predicted at a pixel; the places past the responses are free.
pub type Prediction = [f32; PADDED];

/// Responses as a linear function of features relative to the centre of the fit.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// Prediction at the centre. The first free place holds 1, so that predictions sum up their own weights.
    intercept: Prediction,
    slopes: [Prediction; FEATURES],
}

impl Plane {
    /// Solves the normal equations of `moments` with `ridge` added to the variance of every feature, by Cholesky's
    /// decomposition. Moments are relative to the centre, whose responses are `centre`.
    #[inline(always)]
    pub fn fitted<S: Simd>(simd: S, moments: &Moments, ridge: f32, centre: &[f32]) -> Self {
        let mut matrix = [[0.0; FEATURES]; FEATURES];
        let mut slopes = [[0.0; PADDED]; FEATURES];
        for j in 0..FEATURES {
            matrix[j][..=j].copy_from_slice(&moments.covariance[j][..=j]);
            matrix[j][j] = matrix[j][j].max(0.0) + ridge;
            slopes[j][..RESPONSES].copy_from_slice(&moments.covariance[j][FEATURES..]);
        }
        decompose(&mut matrix);
        solve(simd, &matrix, &mut slopes);
        let mut intercept = [0.0; PADDED];
        for c in 0..RESPONSES {
            intercept[c] = centre[c] + moments.mean[FEATURES + c];
        }
        for j in 0..FEATURES {
            add_multiple(simd, &mut intercept, -moments.mean[j], &slopes[j]);
        }
        intercept[RESPONSES] = 1.0;
        Self { intercept, slopes }
    }

    /// Adds to `sum` the responses at a pixel whose features, relative to the centre, are those of `row`, times
    /// `weight`; to the first free place it adds `weight`.
    #[inline(always)]
    pub fn add_prediction<S: Simd>(&self, simd: S, row: &Row, weight: f32, sum: &mut Prediction) {
        // Wider processors would silently predict nothing.
        const { assert!(PADDED.is_multiple_of(S::F32_LANES)) };
        for part in 0..PADDED / S::F32_LANES {
            let mut value = S::as_simd_f32s(&self.intercept).0[part];
            for j in 0..FEATURES {
                value = simd.mul_add_f32s(simd.splat_f32s(row[j]), S::as_simd_f32s(&self.slopes[j]).0[part], value);
            }
            let sum = &mut S::as_mut_simd_f32s(sum).0[part];
            *sum = simd.mul_add_f32s(simd.splat_f32s(weight), value, *sum);
        }
    }
}

/// Lower Cholesky factor of a symmetric positive matrix, in place; its diagonal as reciprocals.
#[inline(always)]
fn decompose(matrix: &mut [[f32; FEATURES]; FEATURES]) {
    for j in 0..FEATURES {
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
fn solve<S: Simd>(simd: S, factor: &[[f32; FEATURES]; FEATURES], b: &mut [Prediction; FEATURES]) {
    for j in 0..FEATURES {
        let (solved, rest) = b.split_at_mut(j);
        for (m, row) in solved.iter().enumerate() {
            add_multiple(simd, &mut rest[0], -factor[j][m], row);
        }
        rest[0].iter_mut().for_each(|v| *v *= factor[j][j]);
    }
    for j in (0..FEATURES).rev() {
        let (rest, solved) = b.split_at_mut(j + 1);
        for (m, row) in solved.iter().enumerate() {
            add_multiple(simd, &mut rest[j], -factor[j + 1 + m][j], row);
        }
        rest[j].iter_mut().for_each(|v| *v *= factor[j][j]);
    }
}

/// `sum` + `factor` · `values`.
#[inline(always)]
fn add_multiple<S: Simd>(simd: S, sum: &mut Prediction, factor: f32, values: &Prediction) {
    let sums = S::as_mut_simd_f32s(sum).0;
    for (sum, value) in sums.iter_mut().zip(S::as_simd_f32s(values).0) {
        *sum = simd.mul_add_f32s(simd.splat_f32s(factor), *value, *sum);
    }
}

#[cfg(test)]
mod tests;
