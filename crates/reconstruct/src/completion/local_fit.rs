//! A linear fit of colour to place and features in a small window, as the weights it gives to the pixels.

use stack::Size;

use crate::collaborative::FEATURES;
use crate::exp::exp_of_negative;

/// Constant, column and row, then features.
const TERMS: usize = 3 + FEATURES;

type Vector = [f32; TERMS];

/// Fits in windows around any pixel.
#[derive(Clone, Copy, Debug)]
pub struct LocalFit<'a> {
    /// Width and height of all planes.
    pub size: Size,
    /// Features, at most [`FEATURES`].
    pub planes: &'a [Vec<f32>],
    /// Radius of the window, in pixels.
    pub radius: usize,
    /// A pixel counts by exp(−Δ²/(2 s²)), Δ² the squared difference of its features, s this.
    pub likeness: f32,
    /// Ridge on all slopes, for every pixel that counts in full.
    pub ridge: f32,
}

impl LocalFit<'_> {
    /// Pixels of the window and the weight each has in the fit's value at the centre: the equivalent kernel
    /// l = w X (XᵀWX + λ)⁻¹ e₁ of ridge regression. Weights add up to 1.
    pub fn equivalent_kernel(&self, pixel: usize, kernel: &mut Vec<(usize, f32)>) {
        kernel.clear();
        let (x, y, r) = (pixel % self.size.width, pixel / self.size.width, self.radius);
        for row in y.saturating_sub(r)..(y + r + 1).min(self.size.height) {
            for column in x.saturating_sub(r)..(x + r + 1).min(self.size.width) {
                let near = self.size.index(column, row);
                kernel.push((near, self.likeness_of(pixel, near)));
            }
        }
        let mut matrix = [[0.0; TERMS]; TERMS];
        for (near, weight) in kernel.iter() {
            add_outer_product(&mut matrix, &self.terms(pixel, *near), *weight);
        }
        let count = 3 + self.planes.len();
        let total = matrix[0][0];
        (1..count).for_each(|i| matrix[i][i] += self.ridge * total);
        let solution = first_column_of_inverse(&mut matrix, count);
        for (near, weight) in kernel.iter_mut() {
            let terms = self.terms(pixel, *near);
            *weight *= solution.iter().zip(&terms).map(|(a, b)| a * b).sum::<f32>();
        }
    }

    fn likeness_of(&self, pixel: usize, near: usize) -> f32 {
        let squares = self.planes.iter().map(|plane| (plane[pixel] - plane[near]).powi(2));
        exp_of_negative(-squares.sum::<f32>() / (2.0 * self.likeness * self.likeness))
    }

    /// Differences from the centre, which itself is (1, 0, 0 …).
    fn terms(&self, pixel: usize, near: usize) -> Vector {
        let (width, unit) = (self.size.width, 0.5 / self.radius as f32);
        let mut terms = [0.0; TERMS];
        terms[0] = 1.0;
        terms[1] = ((near % width) as f32 - (pixel % width) as f32) * unit;
        terms[2] = ((near / width) as f32 - (pixel / width) as f32) * unit;
        for (term, plane) in terms[3..].iter_mut().zip(self.planes) {
            *term = plane[near] - plane[pixel];
        }
        terms
    }
}

fn add_outer_product(matrix: &mut [Vector; TERMS], terms: &Vector, weight: f32) {
    for (row, a) in matrix.iter_mut().zip(terms) {
        row.iter_mut().zip(terms).for_each(|(sum, b)| *sum += weight * a * b);
    }
}

/// The first column of M⁻¹, M the upper left `count`² of a positive definite matrix, by its factor M = L D Lᵀ.
fn first_column_of_inverse(matrix: &mut [Vector; TERMS], count: usize) -> Vector {
    let mut solution = [0.0; TERMS];
    solution[0] = 1.0;
    for i in 0..count {
        let pivot = matrix[i][i].max(f32::MIN_POSITIVE);
        for j in i + 1..count {
            let factor = matrix[j][i] / pivot;
            for k in i..count {
                matrix[j][k] -= factor * matrix[i][k];
            }
            solution[j] -= factor * solution[i];
        }
    }
    for i in (0..count).rev() {
        let known: f32 = (i + 1..count).map(|k| matrix[i][k] * solution[k]).sum();
        solution[i] = (solution[i] - known) / matrix[i][i].max(f32::MIN_POSITIVE);
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;
    use nalgebra::{DMatrix, DVector};

    const SIZE: Size = Size::new(9, 7);

    fn planes() -> Vec<Vec<f32>> {
        let mut noise = TestNoise(31);
        (0..4).map(|_| noise.normals(SIZE.pixels(), 0.3, 0.1)).collect()
    }

    fn kernel(fit: &LocalFit, pixel: usize) -> Vec<(usize, f32)> {
        let mut kernel = Vec::new();
        fit.equivalent_kernel(pixel, &mut kernel);
        kernel
    }

    #[test]
    fn weights_are_those_of_ridge_regression() {
        let planes = planes();
        let fit = LocalFit { size: SIZE, planes: &planes, radius: 2, likeness: 0.3, ridge: 0.02 };
        for pixel in [0, 31, 40] {
            let found = kernel(&fit, pixel);
            let weights =
                DVector::from_iterator(found.len(), found.iter().map(|(q, _)| f64::from(fit.likeness_of(pixel, *q))));
            let rows: Vec<f64> =
                found.iter().flat_map(|(q, _)| fit.terms(pixel, *q)[..7].to_vec()).map(f64::from).collect();
            let x = DMatrix::from_row_slice(found.len(), 7, &rows);
            let mut gram = x.transpose() * DMatrix::from_diagonal(&weights) * &x;
            (1..7).for_each(|i| gram[(i, i)] += 0.02 * weights.sum());
            let column = gram.try_inverse().unwrap().column(0).into_owned();
            for (i, (_, weight)) in found.iter().enumerate() {
                let expected = weights[i] * x.row(i).transpose().dot(&column);
                assert!((f64::from(*weight) - expected).abs() < 1e-4, "{pixel}: {weight} {expected}");
            }
        }
    }

    #[test]
    fn constants_are_reproduced_and_linear_light_almost() {
        let planes = planes();
        let fit = LocalFit { size: SIZE, planes: &planes, radius: 2, likeness: 1.0, ridge: 1e-6 };
        let light = |q: usize| 1.0 + 0.2 * (q % 9) as f32 - 0.1 * (q / 9) as f32 + 2.0 * planes[1][q] - planes[3][q];
        for pixel in 0..SIZE.pixels() {
            let kernel = kernel(&fit, pixel);
            assert!((kernel.iter().map(|(_, w)| w).sum::<f32>() - 1.0).abs() < 1e-3);
            let fitted: f32 = kernel.iter().map(|(q, w)| w * light(*q)).sum();
            assert!((fitted - light(pixel)).abs() < 5e-3, "{pixel}: {fitted} {}", light(pixel));
        }
    }
}
