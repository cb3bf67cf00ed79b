//! The two proximal steps of robust PCA: shrinking entries, and shrinking singular values.

use nalgebra::DMatrix;

/// S_τ: every entry moves by `threshold` towards zero, and stops there.
pub fn soft_threshold(mut matrix: DMatrix<f64>, threshold: f64) -> DMatrix<f64> {
    matrix.apply(|x| *x = (x.abs() - threshold).max(0.0).copysign(*x));
    matrix
}

/// SVT_τ: every singular value moves by `threshold` towards zero, and stops there.
///
/// By the eigenvectors of the Gram matrix of the smaller side, several times cheaper than a singular value
/// decomposition: with MᵀM = VΣ²Vᵀ, the result is M V max(0, 1 − τ/Σ) Vᵀ. Singular values below some 1e-8 of the
/// largest are lost in rounding. All entries must be finite.
pub fn singular_value_threshold(matrix: &DMatrix<f64>, threshold: f64) -> DMatrix<f64> {
    if matrix.is_empty() {
        return matrix.clone();
    }
    if matrix.nrows() < matrix.ncols() {
        return singular_value_threshold(&matrix.transpose(), threshold).transpose();
    }
    let eigen = matrix.tr_mul(matrix).symmetric_eigen();
    let mut shrunk = DMatrix::zeros(matrix.nrows(), matrix.ncols());
    for (i, eigenvalue) in eigen.eigenvalues.iter().enumerate() {
        let sigma = eigenvalue.max(0.0).sqrt();
        if sigma > threshold {
            let direction = eigen.eigenvectors.column(i);
            shrunk.ger(1.0 - threshold / sigma, &(matrix * direction), &direction, 1.0);
        }
    }
    shrunk
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;

    #[test]
    fn entries_shrink_towards_zero() {
        let matrix = DMatrix::from_row_slice(1, 4, &[3.0, -3.0, 0.5, -0.5]);
        assert_eq!(soft_threshold(matrix, 1.0), DMatrix::from_row_slice(1, 4, &[2.0, -2.0, 0.0, 0.0]));
    }

    #[test]
    fn singular_values_shrink_as_in_the_exact_decomposition() {
        let mut noise = TestNoise(2);
        for (rows, columns) in [(1, 1), (30, 12), (12, 30), (64, 64)] {
            let matrix = DMatrix::from_fn(rows, columns, |_, _| noise.normal());
            for threshold in [0.0, 1.0, 4.0] {
                let mut exact = matrix.clone().svd(true, true);
                exact.singular_values.apply(|s| *s = (*s - threshold).max(0.0));
                let difference = singular_value_threshold(&matrix, threshold) - exact.recompose().unwrap();
                assert!(difference.amax() < 1e-9, "{rows}x{columns} at {threshold}");
            }
        }
    }
}
