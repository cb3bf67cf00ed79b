//! Small systems of normal equations, solved by Cholesky factors.

use pulp::Simd;

use super::lanes::Lanes;

/// Replaces the first `size` rows of `matrix` by the factor R of M = RᵀR, where M's upper triangle fills its first
/// `size` columns. Rows have `stride` numbers; the columns after `size` are right-hand sides B and become R⁻ᵀB.
///
/// Pivots that rounding makes smaller than `least` are raised to it.
#[inline(always)]
pub(crate) fn factor<S: Simd>(simd: S, matrix: &mut [Lanes<S>], size: usize, stride: usize, least: Lanes<S>) {
    for i in 0..size {
        let (above, row) = matrix.split_at_mut(i * stride);
        for earlier in above.chunks_exact(stride) {
            let factor = earlier[i];
            for j in i..stride {
                row[j] = row[j] - factor * earlier[j];
            }
        }
        let inverse = Lanes::splat(simd, 1.0) / row[i].max(least).sqrt();
        for j in i..stride {
            row[j] = row[j] * inverse;
        }
    }
}

/// Replaces column `column` of the factored `matrix` by the solution R⁻¹ times it, from the last row up to row
/// `first`.
#[inline(always)]
pub(crate) fn substitute_back<S: Simd>(
    matrix: &mut [Lanes<S>],
    size: usize,
    stride: usize,
    column: usize,
    first: usize,
) {
    for i in (first..size).rev() {
        let mut value = matrix[i * stride + column];
        for j in i + 1..size {
            value = value - matrix[i * stride + j] * matrix[j * stride + column];
        }
        matrix[i * stride + column] = value / matrix[i * stride + i];
    }
}

/// Writes the first row of M⁻¹ to `row`, given the factor R of M, see [`factor`].
#[inline(always)]
pub(crate) fn first_row_of_inverse<S: Simd>(
    simd: S,
    matrix: &[Lanes<S>],
    size: usize,
    stride: usize,
    row: &mut [Lanes<S>],
) {
    for i in 0..size {
        let mut value = Lanes::splat(simd, if i == 0 { 1.0 } else { 0.0 });
        for j in 0..i {
            value = value - matrix[j * stride + i] * row[j];
        }
        row[i] = value / matrix[i * stride + i];
    }
    for i in (0..size).rev() {
        let mut value = row[i];
        for j in i + 1..size {
            value = value - matrix[i * stride + j] * row[j];
        }
        row[i] = value / matrix[i * stride + i];
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use pulp::Scalar;

    use super::super::twin::Random;
    use super::*;

    /// A positive definite 5 × 5 matrix and one right-hand side, side by side.
    fn system() -> (DMatrix<f64>, Vec<Lanes<Scalar>>) {
        let mut random = Random(9);
        let x = DMatrix::from_fn(12, 5, |_, _| f64::from(random.normal()));
        let full = (x.transpose() * x).insert_column(5, 0.7);
        let lanes = full.transpose().iter().map(|v| Lanes::splat(Scalar, *v as f32)).collect();
        (full, lanes)
    }

    #[test]
    fn solutions_agree_with_nalgebra() {
        let (full, mut lanes) = system();
        let exact = full.columns(0, 5).try_inverse().unwrap() * full.column(5);
        factor(Scalar, &mut lanes, 5, 6, Lanes::splat(Scalar, 0.0));
        substitute_back(&mut lanes, 5, 6, 5, 0);
        for i in 0..5 {
            assert!((f64::from(lanes[i * 6 + 5].to_array()[0]) - exact[i]).abs() < 1e-5);
        }
    }

    #[test]
    fn the_first_row_of_the_inverse_agrees_with_nalgebra() {
        let (full, mut lanes) = system();
        let exact = full.columns(0, 5).try_inverse().unwrap();
        factor(Scalar, &mut lanes, 5, 6, Lanes::splat(Scalar, 0.0));
        let mut row = vec![Lanes::splat(Scalar, 0.0); 5];
        first_row_of_inverse(Scalar, &lanes, 5, 6, &mut row);
        for i in 0..5 {
            assert!((f64::from(row[i].to_array()[0]) - exact[(0, i)]).abs() < 1e-5);
        }
    }
}
