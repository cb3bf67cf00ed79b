//! A linear fit: the responses as a plane over the features.

use super::moments::Moments;
use super::row::{FEATURES, RESPONSES, Row};

/// Responses, padded to what processors take at once.
pub const PADDED: usize = 8;

/// Responses predicted at a pixel; the places past the responses are free.
pub type Prediction = [f32; PADDED];

/// Responses as a linear function of the features relative to the centre of the fit.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// Prediction at the centre. The first free place holds 1, so that predictions sum up their own weights.
    intercept: Prediction,
    slopes: [Prediction; FEATURES],
}

impl Plane {
    /// Solves the normal equations of `moments` with `ridge` added to the variance of every feature, by Cholesky's
    /// decomposition. `centre` is the row the moments are relative to.
    #[inline(always)]
    pub fn fitted(moments: &Moments, ridge: f32, centre: &Row) -> Self {
        let mut matrix = [[0.0; FEATURES]; FEATURES];
        let mut slopes = [[0.0; PADDED]; FEATURES];
        for j in 0..FEATURES {
            matrix[j][..=j].copy_from_slice(&moments.covariance[j][..=j]);
            matrix[j][j] = matrix[j][j].max(0.0) + ridge;
            slopes[j][..RESPONSES].copy_from_slice(&moments.covariance[j][FEATURES..]);
        }
        decompose(&mut matrix);
        solve(&matrix, &mut slopes);
        let mut intercept = [0.0; PADDED];
        for c in 0..RESPONSES {
            intercept[c] = centre[FEATURES + c] + moments.mean[FEATURES + c];
        }
        for j in 0..FEATURES {
            for c in 0..PADDED {
                intercept[c] -= moments.mean[j] * slopes[j][c];
            }
        }
        intercept[RESPONSES] = 1.0;
        Self { intercept, slopes }
    }

    /// Responses at a pixel with the features of `row`; the first free place holds 1.
    #[inline(always)]
    pub fn at(&self, row: &Row, centre: &Row) -> Prediction {
        let mut value = self.intercept;
        for j in 0..FEATURES {
            let x = row[j] - centre[j];
            for c in 0..PADDED {
                value[c] = x.mul_add(self.slopes[j][c], value[c]);
            }
        }
        value
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
fn solve(factor: &[[f32; FEATURES]; FEATURES], b: &mut [Prediction; FEATURES]) {
    for j in 0..FEATURES {
        for m in 0..j {
            take_off(b, j, m, factor[j][m]);
        }
        b[j] = b[j].map(|v| v * factor[j][j]);
    }
    for j in (0..FEATURES).rev() {
        for m in j + 1..FEATURES {
            take_off(b, j, m, factor[m][j]);
        }
        b[j] = b[j].map(|v| v * factor[j][j]);
    }
}

#[inline(always)]
fn take_off(b: &mut [Prediction; FEATURES], from: usize, row: usize, factor: f32) {
    let values = b[row];
    for c in 0..PADDED {
        b[from][c] -= factor * values[c];
    }
}
