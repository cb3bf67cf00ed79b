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
