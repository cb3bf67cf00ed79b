//! Moments against nalgebra in double precision.

use nalgebra::{DMatrix, DVector};

use super::*;
use crate::test_noise::TestNoise;

fn random_window(count: usize, seed: u64) -> (Vec<Row>, Vec<f32>) {
    let mut noise = TestNoise(seed);
    let rows = (0..count).map(|_| std::array::from_fn(|j| 0.1 * j as f32 + noise.normal() as f32)).collect();
    let weights = (0..count).map(|_| noise.uniform() as f32).collect();
    (rows, weights)
}

/// The rows as columns, and the weights, in groups of eight padded with zeros.
pub fn padded(rows: &[Row], weights: &[f32]) -> (Vec<Vec<Lanes>>, Vec<Lanes>) {
    let pad = |values: Vec<f32>| -> Vec<Lanes> {
        let group = |values: &[f32]| std::array::from_fn(|i| values.get(i).copied().unwrap_or(0.0));
        values.chunks(LANES).map(group).collect()
    };
    ((0..WIDTH).map(|j| pad(rows.iter().map(|row| row[j]).collect())).collect(), pad(weights.to_vec()))
}

fn moments_of(rows: &[Row], weights: &[f32]) -> Moments {
    let (columns, weights) = padded(rows, weights);
    let columns: Vec<&[Lanes]> = columns.iter().map(Vec::as_slice).collect();
    Products::new().moments(pulp::Scalar, &columns, FEATURES, &weights)
}

#[test]
fn fewer_responses_have_the_same_moments() {
    let (rows, weights) = random_window(81, 8);
    let (columns, weights) = padded(&rows, &weights);
    let columns: Vec<&[Lanes]> = columns.iter().map(Vec::as_slice).collect();
    let mut products = Products::new();
    let all = products.moments(pulp::Scalar, &columns, FEATURES, &weights);
    for responses in 0..=6 {
        let some = products.moments(pulp::Scalar, &columns[..FEATURES + responses], FEATURES, &weights);
        for (all, some) in all.covariance.iter().zip(&some.covariance) {
            assert_eq!(all[..FEATURES + responses], some[..FEATURES + responses]);
        }
    }
}

#[test]
fn fewer_features_have_the_same_moments() {
    let (rows, weights) = random_window(150, 9);
    let (columns, weights) = padded(&rows, &weights);
    let columns: Vec<&[Lanes]> = columns.iter().map(Vec::as_slice).collect();
    let mut products = Products::new();
    let all = products.moments(pulp::Scalar, &columns, FEATURES, &weights);
    for features in 0..FEATURES {
        let some = products.moments(pulp::Scalar, &columns, features, &weights);
        assert_eq!((some.features, some.weight, some.mean), (features, all.weight, all.mean));
        assert_eq!(some.covariance[..features], all.covariance[..features]);
    }
}

#[test]
fn agree_with_exact_sums() {
    for (count, seed) in [(1, 1), (2, 2), (9, 3), (81, 4), (625, 5)] {
        let (rows, weights) = random_window(count, seed);
        let found = moments_of(&rows, &weights);
        let x = DMatrix::from_fn(count, WIDTH, |i, j| f64::from(rows[i][j]));
        let w = DVector::from_fn(count, |i, _| f64::from(weights[i]));
        let mean = x.tr_mul(&w) / w.sum();
        let spread = DMatrix::from_fn(count, WIDTH, |i, j| x[(i, j)] - mean[j]);
        let weighted = DMatrix::from_fn(count, WIDTH, |i, j| spread[(i, j)] * w[i] / w.sum());
        let covariance = spread.tr_mul(&weighted);
        assert!((f64::from(found.weight) - w.sum()).abs() < 1e-6 * w.sum());
        for j in 0..WIDTH {
            assert!((f64::from(found.mean[j]) - mean[j]).abs() < 5e-6, "mean {j} of {count}");
            for i in 0..FEATURES {
                let difference = f64::from(found.covariance[i][j]) - covariance[(i, j)];
                assert!(difference.abs() < 2e-5, "covariance {i} {j} of {count}: {difference}");
            }
        }
    }
}

#[test]
fn a_factor_on_all_weights_changes_nothing_else() {
    let (rows, weights) = random_window(30, 6);
    let eightfold: Vec<f32> = weights.iter().map(|w| 8.0 * w).collect();
    let [once, more] = [&weights, &eightfold].map(|weights| moments_of(&rows, weights));
    assert_eq!((once.mean, once.covariance), (more.mean, more.covariance));
    assert_eq!(8.0 * once.weight, more.weight);
}

#[test]
fn nothing_is_finite() {
    let (rows, _) = random_window(4, 7);
    for (rows, weights) in [(&rows[..], &[0.0; 4][..]), (&[][..], &[][..])] {
        let found = moments_of(rows, weights);
        assert_eq!((found.weight, found.mean), (0.0, [0.0; WIDTH]));
        assert!(found.covariance.iter().flatten().all(|v| *v == 0.0));
    }
}
