//! A linear fit of colour to place and features in a small window, as the weights it gives to the pixels.

use stack::Size;

use crate::collaborative::{FEATURES, offsets};
use crate::eight::{LANES, Lanes};
use crate::exp::exp_of_negative;
use crate::per_pixel::Pixels;

/// Constant, column and row, then features.
const TERMS: usize = 3 + FEATURES;

/// The terms of one pixel of each window.
type Terms = [Lanes; TERMS];

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
    /// The weight that each pixel of the windows around `pixels`, in the order of [`offsets`], has in the fit's value at
    /// the centre: the equivalent kernel l = w X (XᵀWX + λ)⁻¹ e₁ of ridge regression. Weights add up to 1; outside the picture
    /// they are 0.
    #[inline(always)]
    pub fn equivalent_kernels(&self, pixels: Pixels) -> Vec<Lanes> {
        let count = 3 + self.planes.len();
        let mut kernels = Vec::with_capacity((2 * self.radius + 1).pow(2));
        let mut matrix = [[[0.0; LANES]; TERMS]; TERMS];
        for offset in offsets(self.radius) {
            let terms = self.terms(pixels, offset);
            let weight = self.likeness(pixels, offset, &terms);
            for i in 0..count {
                let mut weighted = [0.0; LANES];
                for lane in 0..LANES {
                    weighted[lane] = weight[lane] * terms[i][lane];
                }
                for j in i..count {
                    for lane in 0..LANES {
                        matrix[i][j][lane] = weighted[lane].mul_add(terms[j][lane], matrix[i][j][lane]);
                    }
                }
            }
            kernels.push(weight);
        }
        let total = matrix[0][0];
        for (i, row) in matrix.iter_mut().enumerate().skip(1) {
            for lane in 0..LANES {
                row[i][lane] += self.ridge * total[lane];
            }
        }
        let solution = first_columns_of_inverses(&mut matrix, count);
        for (offset, kernel) in offsets(self.radius).zip(&mut kernels) {
            let terms = self.terms(pixels, offset);
            let mut value = [0.0; LANES];
            for (solution, terms) in solution.iter().zip(&terms).take(count) {
                for lane in 0..LANES {
                    value[lane] += solution[lane] * terms[lane];
                }
            }
            for lane in 0..LANES {
                kernel[lane] *= value[lane];
            }
        }
        kernels
    }

    /// What pixels of given `terms` count by; outside the picture 0.
    #[inline(always)]
    fn likeness(&self, pixels: Pixels, offset: [isize; 2], terms: &Terms) -> Lanes {
        let inside = pixels.inside(self.size, offset);
        let mut squares = [0.0; LANES];
        for term in &terms[3..3 + self.planes.len()] {
            for lane in 0..LANES {
                squares[lane] += term[lane] * term[lane];
            }
        }
        let mut likeness = [0.0; LANES];
        for lane in 0..LANES {
            likeness[lane] = exp_of_negative(-squares[lane] / (2.0 * self.likeness * self.likeness)) * inside[lane];
        }
        likeness
    }

    /// Differences from the centre, which itself is (1, 0, 0 …).
    #[inline(always)]
    fn terms(&self, pixels: Pixels, offset: [isize; 2]) -> Terms {
        let unit = 0.5 / self.radius as f32;
        let mut terms = [[0.0; LANES]; TERMS];
        terms[0] = [1.0; LANES];
        terms[1] = [offset[0] as f32 * unit; LANES];
        terms[2] = [offset[1] as f32 * unit; LANES];
        for (term, plane) in terms[3..].iter_mut().zip(self.planes) {
            let (near, own) = (pixels.moved(plane, self.size, offset), pixels.of(plane));
            for lane in 0..LANES {
                term[lane] = near[lane] - own[lane];
            }
        }
        terms
    }
}

/// The first columns of M⁻¹, M the upper left `count`² of positive definite matrices of which the upper triangle is given, by
/// the factor M = L D Lᵀ.
#[inline(always)]
fn first_columns_of_inverses(matrix: &mut [Terms; TERMS], count: usize) -> Terms {
    let mut solution = [[0.0; LANES]; TERMS];
    solution[0] = [1.0; LANES];
    for i in 0..count {
        let (above, below) = matrix.split_at_mut(i + 1);
        let row = &above[i];
        for j in i + 1..count {
            let mut factor = [0.0; LANES];
            for lane in 0..LANES {
                factor[lane] = row[j][lane] / row[i][lane].max(f32::MIN_POSITIVE);
                solution[j][lane] -= factor[lane] * solution[i][lane];
            }
            for k in j..count {
                for lane in 0..LANES {
                    below[j - i - 1][k][lane] -= factor[lane] * row[k][lane];
                }
            }
        }
    }
    for i in (0..count).rev() {
        let mut known = [0.0; LANES];
        for k in i + 1..count {
            for lane in 0..LANES {
                known[lane] += matrix[i][k][lane] * solution[k][lane];
            }
        }
        for lane in 0..LANES {
            solution[i][lane] = (solution[i][lane] - known[lane]) / matrix[i][i][lane].max(f32::MIN_POSITIVE);
        }
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::per_pixel::{ByEight, planes_by_eight};
    use crate::test_noise::TestNoise;
    use nalgebra::{DMatrix, DVector};

    const SIZE: Size = Size::new(9, 7);

    /// Pixels of a window of radius 2.
    const WINDOW: usize = 25;

    fn planes() -> Vec<Vec<f32>> {
        let mut noise = TestNoise(31);
        (0..4).map(|_| noise.normals(SIZE.pixels(), 0.3, 0.1)).collect()
    }

    struct Kernels<'a>(LocalFit<'a>);

    impl ByEight<WINDOW> for Kernels<'_> {
        fn numbers(&self, pixels: Pixels) -> [Lanes; WINDOW] {
            self.0.equivalent_kernels(pixels).try_into().unwrap()
        }
    }

    /// The pixels around each pixel, and their weights.
    fn kernels(fit: LocalFit) -> Vec<Vec<(usize, f32)>> {
        let weights = planes_by_eight(SIZE.pixels(), &Kernels(fit));
        let of = |pixel: usize| {
            let (x, y) = ((pixel % SIZE.width) as isize, (pixel / SIZE.width) as isize);
            let mut kernel = Vec::new();
            for ([dx, dy], weights) in offsets(fit.radius).zip(&weights) {
                let (x, y) = (x + dx, y + dy);
                if (0..SIZE.width as isize).contains(&x) && (0..SIZE.height as isize).contains(&y) {
                    kernel.push((SIZE.index(x as usize, y as usize), weights[pixel]));
                } else {
                    assert_eq!(weights[pixel], 0.0);
                }
            }
            kernel
        };
        (0..SIZE.pixels()).map(of).collect()
    }

    /// Constant, column, row and features of `near`, as seen from `pixel`.
    fn row(planes: &[Vec<f32>], pixel: usize, near: usize) -> Vec<f64> {
        let place = |i: usize| [(i % SIZE.width) as f64, (i / SIZE.width) as f64];
        let step = |axis: usize| 0.25 * (place(near)[axis] - place(pixel)[axis]);
        let features = planes.iter().map(|plane| f64::from(plane[near] - plane[pixel]));
        [1.0, step(0), step(1)].into_iter().chain(features).collect()
    }

    #[test]
    fn weights_are_those_of_ridge_regression() {
        let planes = planes();
        let fit = LocalFit { size: SIZE, planes: &planes, radius: 2, likeness: 0.3, ridge: 0.02 };
        for (pixel, found) in kernels(fit).iter().enumerate() {
            let rows: Vec<Vec<f64>> = found.iter().map(|(near, _)| row(&planes, pixel, *near)).collect();
            let likeness = |row: &Vec<f64>| (-row[3..].iter().map(|v| v * v).sum::<f64>() / (2.0 * 0.3 * 0.3)).exp();
            let weights = DVector::from_iterator(rows.len(), rows.iter().map(likeness));
            let x = DMatrix::from_row_slice(rows.len(), 7, &rows.concat());
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
        for (pixel, kernel) in kernels(fit).iter().enumerate() {
            assert!((kernel.iter().map(|(_, w)| w).sum::<f32>() - 1.0).abs() < 1e-3);
            let fitted: f32 = kernel.iter().map(|(q, w)| w * light(*q)).sum();
            assert!((fitted - light(pixel)).abs() < 5e-3, "{pixel}: {fitted} {}", light(pixel));
        }
    }
}
