//! Planes against ridge regression by exact singular value decomposition.

use super::super::moments::tests::padded;
use super::super::moments::{Moments, Products};
use super::super::row::{RESPONSES, Row, WIDTH};
use super::super::twin::{predicted, ridge_fit};
use super::*;
use crate::eight::LANES;
use crate::test_noise::TestNoise;

const SCALAR: pulp::Scalar = pulp::Scalar;

fn random_window(count: usize, seed: u64) -> (Vec<Row>, Vec<f32>) {
    let mut noise = TestNoise(seed);
    let rows = (0..count).map(|_| std::array::from_fn(|_| 0.3 * noise.normal() as f32)).collect();
    let weights = (0..count).map(|_| 0.05 + noise.uniform() as f32).collect();
    (rows, weights)
}

fn moments_of(rows: &[Row], weights: &[f32]) -> Moments {
    let (columns, weights) = padded(rows, weights);
    let columns: Vec<&[Lanes]> = columns.iter().map(Vec::as_slice).collect();
    Products::new().moments(SCALAR, &columns, FEATURES, &weights)
}

/// What `plane` predicts at `rows`, times `weight`.
fn predict(plane: &Plane, rows: &[Row], weight: f32) -> Vec<[f32; RESPONSES]> {
    let (columns, weights) = padded(rows, &vec![weight; rows.len()]);
    let mut out = vec![[0.0; LANES]; RESPONSES * weights.len()];
    let columns: Vec<&[Lanes]> = columns.iter().map(Vec::as_slice).collect();
    plane.predict(SCALAR, &columns, &weights, RESPONSES, &mut out);
    let of_response = |c: usize, i: usize| out[c * weights.len()..].as_flattened()[i];
    (0..rows.len()).map(|i| std::array::from_fn(|c| of_response(c, i))).collect()
}

/// Responses of the fit of `rows` at `row`; both are relative to a centre with responses `centre`.
fn fit_at(rows: &[Row], weights: &[f32], ridge: f32, centre: &[f32], row: &Row) -> [f32; RESPONSES] {
    predict(&Plane::fitted(SCALAR, &moments_of(rows, weights), ridge, centre), &[*row], 1.0)[0]
}

#[test]
fn agree_with_exact_ridge_regression() {
    for (count, ridge) in [(40, 1e-3), (40, 0.5), (200, 1e-4), (6, 1e-2), (1, 1e-2)] {
        let (rows, weights) = random_window(count, 10 + count as u64);
        let exact_weights: Vec<f64> = weights.iter().map(|w| f64::from(*w)).collect();
        let exact = ridge_fit(&rows, &exact_weights, f64::from(ridge));
        for row in rows.iter().take(8) {
            let (found, expected) = (fit_at(&rows, &weights, ridge, &[0.0; RESPONSES], row), predicted(&exact, row));
            for c in 0..RESPONSES {
                let difference = f64::from(found[c]) - expected[c];
                assert!(difference.abs() < 2e-4, "{count} pixels, λ = {ridge}: {difference}");
            }
        }
    }
}

#[test]
fn linear_data_give_their_intercepts_and_slopes() {
    let (mut rows, weights) = random_window(60, 31);
    let slope = |j: usize, c: usize| 0.5 * (j as f32) - c as f32;
    for row in &mut rows {
        for c in 0..RESPONSES {
            row[FEATURES + c] = 0.25 + (0..FEATURES).map(|j| slope(j, c) * row[j]).sum::<f32>();
        }
    }
    let centre: [f32; RESPONSES] = std::array::from_fn(|c| 10.0 * c as f32);
    let at = |row: &Row| fit_at(&rows, &weights, 1e-8, &centre, row);
    let intercept = at(&[0.0; WIDTH]);
    for c in 0..RESPONSES {
        assert!((intercept[c] - centre[c] - 0.25).abs() < 1e-4, "intercept {c}: {}", intercept[c]);
        for j in 0..FEATURES {
            let mut unit = [0.0; WIDTH];
            unit[j] = 1.0;
            let found = at(&unit)[c] - intercept[c];
            assert!((found - slope(j, c)).abs() < 1e-3, "slope {j} of {c}: {found}");
        }
    }
}

#[test]
fn features_that_do_not_vary_have_no_say() {
    let (mut rows, weights) = random_window(50, 32);
    rows.iter_mut().for_each(|row| row[..FEATURES].fill(0.0));
    let mean = moments_of(&rows, &weights).mean;
    let mut far = [0.0; WIDTH];
    far[..FEATURES].fill(100.0);
    let found = fit_at(&rows, &weights, 1e-5, &[2.0; RESPONSES], &far);
    for c in 0..RESPONSES {
        assert!((found[c] - 2.0 - mean[FEATURES + c]).abs() < 1e-6);
    }
}

#[test]
fn any_number_of_pixels_is_predicted_with_its_weight() {
    let (rows, weights) = random_window(70, 33);
    let plane = Plane::fitted(SCALAR, &moments_of(&rows, &weights), 1e-3, &[1.0; RESPONSES]);
    for count in [1, 8, 17, 33, 70] {
        for (found, row) in predict(&plane, &rows[..count], 0.25).iter().zip(&rows) {
            let once = predict(&plane, &[*row], 1.0)[0];
            assert!((0..RESPONSES).all(|c| (found[c] - 0.25 * once[c]).abs() < 1e-6));
        }
    }
}
