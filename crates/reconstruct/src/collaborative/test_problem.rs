//! Small problems for tests.

use stack::Size;

use super::row::{FEATURES, RESPONSES, Row, WIDTH};
use super::{Fitted, Guides, Predicted, Ridge};
use crate::patch_distance::PatchComparison;
use crate::patch_distance::tests::random_planes;
use crate::test_noise::TestNoise;

/// Everything a fit rests on.
pub struct Problem {
    pub size: Size,
    pub rows: Vec<Row>,
    pub importance: Vec<f32>,
    pub noise: Vec<f32>,
    values: Vec<Vec<f32>>,
    variances: Vec<Vec<f32>>,
}

impl Problem {
    /// Random features, responses, weights and guide.
    pub fn random(size: Size, seed: u64) -> Self {
        let mut noise = TestNoise(seed);
        let [values, variances] = random_planes(size, 3, seed + 1);
        let row = |_| std::array::from_fn(|_| 0.5 * noise.normal() as f32 + 0.2);
        let rows = (0..size.pixels()).map(row).collect();
        let mut between = |low: f64, high: f64| -> Vec<f32> {
            (0..size.pixels()).map(|_| (low + (high - low) * noise.uniform()) as f32).collect()
        };
        Self { size, rows, importance: between(0.5, 2.0), noise: between(0.0, 1.0), values, variances }
    }

    /// The same with responses that are linear in the features.
    pub fn linear(size: Size, seed: u64) -> Self {
        let mut problem = Self::random(size, seed);
        let mut noise = TestNoise(seed + 2);
        let slopes: [[f32; RESPONSES]; FEATURES] =
            [[0.0; RESPONSES]; FEATURES].map(|s| s.map(|_| noise.normal() as f32));
        for row in &mut problem.rows {
            for c in 0..RESPONSES {
                row[FEATURES + c] = 1.0 + c as f32 + (0..FEATURES).map(|j| slopes[j][c] * row[j]).sum::<f32>();
            }
        }
        problem
    }

    /// The same guided by `values` of next to no variance.
    pub fn guided_by(self, values: Vec<f32>) -> Self {
        let variances = vec![vec![1e-4; values.len()]];
        Self { values: vec![values], variances, ..self }
    }

    /// Gives all responses of pixel `index` the same value.
    pub fn set_responses(&mut self, index: usize, value: f32) {
        self.rows[index][FEATURES..].fill(value);
    }

    /// The rows as planes: features, then responses.
    pub fn planes(&self) -> Planes {
        let plane = |place: usize| self.rows.iter().map(|row| row[place]).collect();
        Planes { features: (0..FEATURES).map(plane).collect(), responses: (FEATURES..WIDTH).map(plane).collect() }
    }

    /// A fit of all responses with the weights of one guide.
    pub fn fitted<'a>(
        &'a self,
        planes: &'a Planes,
        responses: &'a [&'a [&'a [f32]]],
        least: f32,
        stride: usize,
    ) -> Fitted<'a> {
        let ridge = Ridge { least, per_noise: 0.0 };
        let (features, noise) = (&planes.features[..], &self.noise[..]);
        Fitted { features, responses, importance: None, noise, ridge, stride, covered: 1.0 }
    }

    /// The planes that are compared.
    pub fn values(&self) -> &[Vec<f32>] {
        &self.values
    }

    pub fn guides<'a>(&'a self, values: &'a [&'a [Vec<f32>]], radius: usize) -> Guides<'a> {
        Guides {
            size: self.size,
            values,
            variances: &self.variances,
            comparison: PatchComparison { patch_radius: 1, epsilon: 1e-6, noise_taken_off: 1.0 },
            radius,
        }
    }

    /// The largest difference between what is predicted and the responses of the rows.
    pub fn largest_difference(&self, predicted: &Predicted) -> f32 {
        let of_plane = |(place, plane): (usize, &Vec<f32>)| {
            plane.iter().zip(&self.rows).map(|(value, row)| (value - row[place]).abs()).fold(0.0, nan_or_larger)
        };
        (FEATURES..WIDTH).zip(predicted.iter().flatten()).map(of_plane).fold(0.0, nan_or_larger)
    }
}

/// The planes of a [`Problem`].
pub struct Planes {
    features: Vec<Vec<f32>>,
    responses: Vec<Vec<f32>>,
}

impl Planes {
    /// All responses.
    pub fn responses(&self) -> Vec<&[f32]> {
        self.responses.iter().map(Vec::as_slice).collect()
    }
}

/// Unlike `f32::max`, does not forget what is not a number.
fn nan_or_larger(a: f32, b: f32) -> f32 {
    if a.is_nan() || b > a || b.is_nan() { a + b - a } else { a }
}
