//! Collaborative regression as its formulas stand: one fit at a time, in double precision, by singular value
//! decomposition of the weighted design matrix instead of normal equations.

use nalgebra::{DMatrix, DVector};

use super::row::{FEATURES, RESPONSES, Row};
use super::{Fitted, Guides, Kernel, offsets};
use crate::patch_distance::NoisyPlanes;
use crate::patch_distance::tests::distance_twin;

/// Coefficients of the ridge regression that minimises Σ w (y − a − b·x)²/Σ w + λ |b|²: intercepts a in the first row,
/// slopes b below, a column per response.
pub fn ridge_fit(rows: &[Row], weights: &[f64], ridge: f64) -> DMatrix<f64> {
    let total: f64 = weights.iter().sum();
    let share = |i: usize| (weights[i] / total).sqrt();
    let design = DMatrix::from_fn(rows.len() + FEATURES, FEATURES + 1, |i, j| match (rows.get(i), j) {
        (Some(_), 0) => share(i),
        (Some(row), _) => share(i) * f64::from(row[j - 1]),
        (None, _) => {
            if i - rows.len() + 1 == j {
                ridge.sqrt()
            } else {
                0.0
            }
        }
    });
    let responses = DMatrix::from_fn(rows.len() + FEATURES, RESPONSES, |i, c| {
        rows.get(i).map_or(0.0, |row| share(i) * f64::from(row[FEATURES + c]))
    });
    design.svd(true, true).solve(&responses, 0.0).unwrap()
}

/// Responses that `coefficients` predict at `row`.
pub fn predicted(coefficients: &DMatrix<f64>, row: &Row) -> DVector<f64> {
    let design = DVector::from_fn(FEATURES + 1, |j, _| if j == 0 { 1.0 } else { f64::from(row[j - 1]) });
    coefficients.tr_mul(&design)
}

/// What [`super::collaborate`] computes for the first guide, one kernel and a stride of one: all responses of every pixel.
pub fn collaborate_twin(fitted: &Fitted, rows: &[Row], guide: &Guides, kernel: &Kernel) -> Vec<Vec<f64>> {
    let size = guide.size;
    let mut sums = vec![DVector::zeros(RESPONSES); size.pixels()];
    let mut totals = vec![0.0; size.pixels()];
    for centre in 0..size.pixels() {
        let window = window(guide, kernel, centre);
        let importance = |pixel: usize| fitted.importance.map_or(1.0, |all| f64::from(all[pixel] / all[centre]));
        let weights: Vec<f64> = window.iter().map(|(pixel, kernel)| kernel * importance(*pixel)).collect();
        let noise: f64 = window.iter().map(|(pixel, kernel)| kernel * kernel * f64::from(fitted.noise[*pixel])).sum();
        let ridge = f64::from(fitted.ridge.least)
            + f64::from(fitted.ridge.per_noise) * noise / weights.iter().sum::<f64>().powi(2);
        let rows: Vec<Row> = window.iter().map(|(pixel, _)| rows[*pixel]).collect();
        let fit = ridge_fit(&rows, &weights, ridge);
        for ((pixel, kernel), row) in window.iter().zip(&rows) {
            sums[*pixel] += *kernel * predicted(&fit, row);
            totals[*pixel] += kernel;
        }
    }
    sums.iter().zip(&totals).map(|(sum, total)| sum.iter().map(|v| v / total).collect()).collect()
}

/// Pixels around `centre` and their weights, without those that do not count.
fn window(guide: &Guides, kernel: &Kernel, centre: usize) -> Vec<(usize, f64)> {
    let (width, height) = (guide.size.width as isize, guide.size.height as isize);
    let planes = NoisyPlanes { size: guide.size, values: guide.values[0], variances: guide.variances };
    let c = [centre as isize % width, centre as isize / width];
    offsets(guide.radius)
        .map(|[dx, dy]| ([c[0] + dx, c[1] + dy], (dx * dx + dy * dy) as f64))
        .filter(|([x, y], _)| (0..width).contains(x) && (0..height).contains(y))
        .map(|(q, squared)| {
            let [bandwidth, sigma] = [kernel.bandwidth, kernel.sigma].map(f64::from);
            let distance = distance_twin(planes, c, q, guide.comparison);
            let weight = (-distance / (bandwidth * bandwidth) - squared / (2.0 * sigma * sigma)).exp();
            ((q[0] + q[1] * width) as usize, weight)
        })
        .filter(|(_, weight)| *weight >= 1e-4)
        .collect()
}
