//! Orthogonalisation of a block's terms, one after the other; what earlier terms explain is left out.

use pulp::Simd;

use crate::regression::lanes::Lanes;

/// A term is left out when earlier ones explain all but this share of it: the rest would be rounding.
const LEAST_SHARE: f32 = 1e-4;

/// Replaces the first `size` rows of `matrix`, whose upper triangle is XᵀX followed by right-hand sides Xᵀy in rows of
/// `stride` numbers, by R and R⁻ᵀXᵀy; writes the inverses of R's diagonal to `inverse`. A term whose residual has a sum
/// of squares of less than `least`, or a negligible share of its own, becomes a row of zeros with inverse 0.
#[inline(always)]
pub(crate) fn factor_dropping<S: Simd>(
    simd: S,
    matrix: &mut [Lanes<S>],
    (size, stride): (usize, usize),
    least: Lanes<S>,
    inverse: &mut [Lanes<S>],
) {
    let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
    for i in 0..size {
        let (above, row) = matrix.split_at_mut(i * stride);
        let bound = (row[i] * LEAST_SHARE).max(least);
        for earlier in above.chunks_exact(stride) {
            let factor = earlier[i];
            for j in i..stride {
                row[j] = row[j] - factor * earlier[j];
            }
        }
        let kept = bound.less_than(row[i]);
        let root = row[i].max(bound).sqrt();
        inverse[i] = kept.select(one / root, zero);
        for j in i..stride {
            row[j] = row[j] * inverse[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use pulp::Scalar;

    use super::*;
    use crate::regression::twin::Random;

    /// Rows of four terms, the third of which is the sum of the others before it, and a value.
    fn rows() -> DMatrix<f64> {
        let mut random = Random(4);
        let mut x = DMatrix::from_fn(30, 5, |_, _| f64::from(random.normal()));
        let sum = x.column(0) + x.column(1);
        x.set_column(2, &sum);
        x
    }

    #[test]
    fn fits_agree_with_least_squares_on_the_independent_terms() {
        let x = rows();
        let mut lanes: Vec<Lanes<Scalar>> =
            (x.transpose() * &x).transpose().iter().map(|v| Lanes::splat(Scalar, *v as f32)).collect();
        let mut inverse = vec![Lanes::splat(Scalar, 0.0); 4];
        factor_dropping(Scalar, &mut lanes[..20], (4, 5), Lanes::splat(Scalar, 1e-6), &mut inverse);
        assert_eq!(inverse[2].to_array()[0], 0.0);
        let independent = x.select_columns(&[0, 1, 3]);
        let y = x.column(4);
        let normal = independent.transpose() * &independent;
        let solution = normal.try_inverse().unwrap() * independent.transpose() * y;
        let explained = (independent * solution).norm_squared();
        let found: f32 = (0..4).map(|j| lanes[j * 5 + 4].to_array()[0].powi(2)).sum();
        assert!((f64::from(found) / explained - 1.0).abs() < 1e-4, "{found} for {explained}");
    }
}
