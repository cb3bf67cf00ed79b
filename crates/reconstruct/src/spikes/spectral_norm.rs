//! Largest singular value by power iteration.

use nalgebra::{DMatrix, DVector};

/// Most iterations. Two singular values so close that this does not part them give the same norm anyway.
const MOST_ITERATIONS: usize = 1000;

/// Relative growth of the estimate below which it counts as settled.
const SETTLED: f64 = 1e-12;

/// ‖M‖₂, the largest singular value of `matrix`. All entries must be finite, their squares too.
pub fn spectral_norm(matrix: &DMatrix<f64>) -> f64 {
    let mut direction = matrix.tr_mul(&irregular(matrix.nrows()));
    let mut norm = 0.0;
    for _ in 0..MOST_ITERATIONS {
        let length = direction.norm();
        if length == 0.0 {
            break;
        }
        let image = matrix * (direction / length);
        let estimate = image.norm();
        direction = matrix.tr_mul(&image);
        if estimate <= norm * (1.0 + SETTLED) {
            return estimate.max(norm);
        }
        norm = estimate;
    }
    norm
}

/// A start that no pattern of rows is likely to be orthogonal to: multiples of the golden ratio, wrapped to [½, 1½).
fn irregular(length: usize) -> DVector<f64> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    DVector::from_fn(length, |i, _| 0.5 + (i as f64 * GOLDEN).fract())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;

    #[test]
    fn agrees_with_the_exact_decomposition() {
        let mut noise = TestNoise(7);
        for (rows, columns) in [(1, 1), (1, 9), (9, 1), (40, 10), (10, 40), (64, 64)] {
            for mean in [0.0, 1.0] {
                let matrix = DMatrix::from_fn(rows, columns, |_, _| mean + noise.normal());
                let exact = matrix.clone().svd(false, false).singular_values.max();
                assert!((spectral_norm(&matrix) / exact - 1.0).abs() < 1e-8, "{rows}x{columns}");
            }
        }
    }

    #[test]
    fn finds_directions_that_sum_to_zero() {
        let alternating = DMatrix::from_fn(8, 6, |i, j| if (i + j) % 2 == 0 { 1.0 } else { -1.0 });
        assert!((spectral_norm(&alternating) - 48.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(spectral_norm(&DMatrix::zeros(4, 4)), 0.0);
    }
}
