//! Weighted first and second moments of a window, for the normal equations.

use pulp::Simd;

use super::row::{FEATURES, Row, WIDTH};

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

/// Moments of `rows` with one of `weights` each. Fused multiplications are used on every machine alike.
#[inline(always)]
pub fn moments<S: Simd>(simd: S, rows: &[Row], weights: &[f32]) -> Moments {
    let (mut products, mut mean) = ([[0.0; WIDTH]; FEATURES], [0.0; WIDTH]);
    // A sweep per part of the row: the sums of one fill the processor's registers.
    for part in 0..WIDTH / S::F32_LANES {
        let (mut sums, mut sum) = ([simd.splat_f32s(0.0); FEATURES], simd.splat_f32s(0.0));
        for (row, weight) in rows.iter().zip(weights) {
            let weighted = simd.mul_f32s(simd.splat_f32s(*weight), S::as_simd_f32s(row).0[part]);
            sum = simd.add_f32s(sum, weighted);
            for j in 0..FEATURES {
                sums[j] = simd.mul_add_f32s(simd.splat_f32s(row[j]), weighted, sums[j]);
            }
        }
        S::as_mut_simd_f32s(&mut mean).0[part] = sum;
        for j in 0..FEATURES {
            S::as_mut_simd_f32s(&mut products[j]).0[part] = sums[j];
        }
    }
    centred(products, mean, weights.iter().sum())
}

/// Sums of products made into covariances.
#[inline(always)]
fn centred(mut products: [Row; FEATURES], mut mean: Row, weight: f32) -> Moments {
    let scale = 1.0 / weight.max(1e-20);
    mean.iter_mut().for_each(|sum| *sum *= scale);
    for (row, own) in products.iter_mut().zip(mean) {
        for (product, other) in row.iter_mut().zip(mean) {
            *product = *product * scale - own * other;
        }
    }
    Moments { covariance: products, mean, weight }
}

#[cfg(test)]
mod tests;
