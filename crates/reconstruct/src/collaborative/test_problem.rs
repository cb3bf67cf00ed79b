//! Small problems for tests.

use stack::{Image, Size};

use super::row::{FEATURES, RESPONSES, Row, WIDTH};
use super::{Fitted, Guide, Ridge};
use crate::patch_distance::tests::random_planes;
use crate::patch_distance::{Comparison, NoisyPlanes};
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

    pub fn fitted(&self, least: f32, stride: usize) -> Fitted<'_> {
        let ridge = Ridge { least, per_noise: 0.0 };
        Fitted { rows: &self.rows, importance: None, noise: &self.noise, ridge, stride }
    }

    pub fn guide(&self, radius: usize) -> Guide<'_> {
        Guide {
            planes: NoisyPlanes { size: self.size, values: &self.values, variances: &self.variances },
            comparison: Comparison { patch_radius: 1, epsilon: 1e-6, noise_taken_off: 1.0 },
            radius,
        }
    }

    /// The largest difference between `halves` and the responses of the rows.
    pub fn largest_difference(&self, halves: &[Image; 2]) -> f32 {
        let predicted = halves.iter().flat_map(|half| half.channels());
        let of_plane = |(place, plane): (usize, &Vec<f32>)| {
            plane.iter().zip(&self.rows).map(|(value, row)| (value - row[place]).abs()).fold(0.0, nan_or_larger)
        };
        (FEATURES..WIDTH).zip(predicted).map(of_plane).fold(0.0, nan_or_larger)
    }
}

/// Unlike `f32::max`, does not forget what is not a number.
fn nan_or_larger(a: f32, b: f32) -> f32 {
    if a.is_nan() || b > a || b.is_nan() { a + b - a } else { a }
}
