//! Robust PCA by the inexact augmented Lagrange multiplier method.
//!
//! Z. Lin, M. Chen, Y. Ma, *The augmented Lagrange multiplier method for exact recovery of corrupted low-rank matrices*,
//! 2010, algorithm 5: the `ALM(D, A, E, iterations)` of the paper's section 4.1. This is the general and reference
//! version, in double precision; hot loops over small matrices have their own.

use nalgebra::DMatrix;

use super::shrinkage::{singular_value_threshold, soft_threshold};
use super::spectral_norm::spectral_norm;

stack::knob_choice! {
    /// Which of its two matrices an iteration updates first.
    pub enum UpdateOrder {
        /// The sparse one.
        SparseFirst = "sparse-first",
        /// The low-rank one.
        LowRankFirst = "low-rank-first",
    }
}

/// How a matrix is decomposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlmSettings {
    /// Most iterations to make.
    pub iterations: usize,
    /// What each of them updates first.
    pub order: UpdateOrder,
    /// λ of eq. 9, as a multiple of 1/√max(m, n).
    pub lambda: f64,
    /// Stop as soon as ‖D − A − E‖ ≤ `tolerance` · ‖D‖ (Frobenius norms).
    pub tolerance: f64,
}

impl Default for AlmSettings {
    fn default() -> Self {
        Self { iterations: 1, order: UpdateOrder::SparseFirst, lambda: 1.0, tolerance: 1e-7 }
    }
}

/// A matrix D taken apart: D ≈ A + E. With few iterations the sum misses D (after one, visibly).
#[derive(Clone, Debug, PartialEq)]
struct Alm {
    /// A, of low rank.
    pub low_rank: DMatrix<f64>,
    /// E, with few entries other than zero.
    pub sparse: DMatrix<f64>,
    /// Iterations made.
    pub iterations: usize,
}

/// Growth of the penalty μ in every iteration.
const GROWTH: f64 = 1.5;

/// The penalty grows to at most this multiple of its first value, as in the authors' program.
const GROWTH_LIMIT: f64 = 1e7;

/// Decomposes `matrix` (any shape) into a low-rank and a sparse part (eq. 9). Non-finite entries count as zero; for a
/// matrix of zeros both parts are zero.
fn inexact_alm(matrix: &DMatrix<f64>, settings: &AlmSettings) -> Alm {
    let Some(mut iterate) = Iterate::start(matrix, settings.lambda) else { return nothing(matrix) };
    let mut iterations = 0;
    while iterations < settings.iterations {
        match settings.order {
            UpdateOrder::SparseFirst => {
                iterate.update_sparse();
                iterate.update_low_rank();
            }
            UpdateOrder::LowRankFirst => {
                iterate.update_low_rank();
                iterate.update_sparse();
            }
        }
        iterations += 1;
        if iterate.update_multiplier() <= settings.tolerance {
            break;
        }
    }
    Alm { low_rank: iterate.low_rank * iterate.scale, sparse: iterate.sparse * iterate.scale, iterations }
}

/// The sparse part of [`inexact_alm`] alone. One sparse-first iteration needs no singular vectors for it.
pub fn sparse_part(matrix: &DMatrix<f64>, settings: &AlmSettings) -> DMatrix<f64> {
    if settings.iterations != 1 || settings.order != UpdateOrder::SparseFirst {
        return inexact_alm(matrix, settings).sparse;
    }
    let Some(mut iterate) = Iterate::start(matrix, settings.lambda) else { return nothing(matrix).sparse };
    iterate.update_sparse();
    iterate.sparse * iterate.scale
}

fn nothing(matrix: &DMatrix<f64>) -> Alm {
    let zero = DMatrix::zeros(matrix.nrows(), matrix.ncols());
    Alm { low_rank: zero.clone(), sparse: zero, iterations: 0 }
}

/// Where the iteration stands. Everything is divided by `scale`, the largest entry of D, so that no product of entries
/// can overflow.
struct Iterate {
    scale: f64,
    lambda: f64,
    data: DMatrix<f64>,
    low_rank: DMatrix<f64>,
    sparse: DMatrix<f64>,
    multiplier: DMatrix<f64>,
    penalty: f64,
    most_penalty: f64,
}

impl Iterate {
    /// A₀ = E₀ = 0, Y₀ = D/J with J = max(‖D‖₂, ‖D‖∞/λ), μ₀ = 1.25/‖D‖₂. `None` when D is zero.
    fn start(matrix: &DMatrix<f64>, lambda: f64) -> Option<Self> {
        let finite = matrix.map(|x| if x.is_finite() { x } else { 0.0 });
        let scale = finite.amax();
        if scale < f64::MIN_POSITIVE {
            return None;
        }
        let data = finite / scale;
        let zero = DMatrix::zeros(data.nrows(), data.ncols());
        let lambda = lambda / (data.nrows().max(data.ncols()) as f64).sqrt();
        let norm = spectral_norm(&data);
        let multiplier = &data / norm.max(1.0 / lambda);
        let penalty = 1.25 / norm;
        let most_penalty = penalty * GROWTH_LIMIT;
        Some(Self { scale, lambda, data, low_rank: zero.clone(), sparse: zero, multiplier, penalty, most_penalty })
    }

    /// E = S_{λ/μ}(D − A + Y/μ).
    fn update_sparse(&mut self) {
        let rest = &self.data - &self.low_rank + &self.multiplier / self.penalty;
        self.sparse = soft_threshold(rest, self.lambda / self.penalty);
    }

    /// A = SVT_{1/μ}(D − E + Y/μ).
    fn update_low_rank(&mut self) {
        let rest = &self.data - &self.sparse + &self.multiplier / self.penalty;
        self.low_rank = singular_value_threshold(&rest, 1.0 / self.penalty);
    }

    /// Y += μ(D − A − E), μ grows; returns ‖D − A − E‖/‖D‖.
    fn update_multiplier(&mut self) -> f64 {
        let residual = &self.data - &self.low_rank - &self.sparse;
        let error = residual.norm() / self.data.norm();
        self.multiplier += residual * self.penalty;
        self.penalty = (self.penalty * GROWTH).min(self.most_penalty);
        error
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;

    fn random(rows: usize, columns: usize, seed: u64) -> DMatrix<f64> {
        let mut noise = TestNoise(seed);
        DMatrix::from_fn(rows, columns, |_, _| noise.normal())
    }

    /// nalgebra's exact decomposition: the largest singular value.
    fn exact_norm(matrix: &DMatrix<f64>) -> f64 {
        matrix.clone().svd(false, false).singular_values.max()
    }

    /// nalgebra's exact decomposition, singular values lowered by `threshold`.
    fn exact_svt(matrix: &DMatrix<f64>, threshold: f64) -> DMatrix<f64> {
        let mut svd = matrix.clone().svd(true, true);
        svd.singular_values.apply(|s| *s = (*s - threshold).max(0.0));
        svd.recompose().unwrap()
    }

    fn shrink(matrix: &DMatrix<f64>, threshold: f64) -> DMatrix<f64> {
        matrix.map(|x| x.signum() * (x.abs() - threshold).max(0.0))
    }

    /// The whole method with exact singular value decompositions, as the authors write it.
    fn twin(d: &DMatrix<f64>, settings: &AlmSettings) -> (DMatrix<f64>, DMatrix<f64>) {
        let lambda = settings.lambda / (d.nrows().max(d.ncols()) as f64).sqrt();
        let mut mu = 1.25 / exact_norm(d);
        let mut y = d / exact_norm(d).max(d.amax() / lambda);
        let (mut a, mut e) = (d * 0.0, d * 0.0);
        for _ in 0..settings.iterations {
            if settings.order == UpdateOrder::SparseFirst {
                e = shrink(&(d - &a + &y / mu), lambda / mu);
            }
            a = exact_svt(&(d - &e + &y / mu), 1.0 / mu);
            if settings.order == UpdateOrder::LowRankFirst {
                e = shrink(&(d - &a + &y / mu), lambda / mu);
            }
            y += (d - &a - &e) * mu;
            mu *= GROWTH;
        }
        (a, e)
    }

    #[test]
    fn one_iteration_is_the_closed_form() {
        for (rows, columns) in [(20, 20), (31, 7), (6, 40)] {
            let d = random(rows, columns, 3).map(f64::abs);
            let lambda = 1.0 / (rows.max(columns) as f64).sqrt();
            let s = exact_norm(&d);
            let c = 1.0 + 0.8 * s / s.max(d.amax() / lambda);
            let sparse = shrink(&(&d * c), 0.8 * lambda * s);
            let low_rank = exact_svt(&(&d * c - &sparse), 0.8 * s);
            let ours = inexact_alm(&d, &AlmSettings::default());
            assert!((ours.sparse - &sparse).amax() < 1e-6);
            assert!((ours.low_rank - low_rank).amax() < 1e-6);
            assert!((sparse_part(&d, &AlmSettings::default()) - sparse).amax() < 1e-6);

            let settings = AlmSettings { order: UpdateOrder::LowRankFirst, ..AlmSettings::default() };
            let ours = inexact_alm(&d, &settings);
            let low_rank = exact_svt(&(&d * c), 0.8 * s);
            assert!((ours.sparse - shrink(&(&d * c - &low_rank), 0.8 * lambda * s)).amax() < 1e-6);
            assert!((ours.low_rank - low_rank).amax() < 1e-6);
        }
    }

    #[test]
    fn every_iteration_follows_the_twin_with_exact_decompositions() {
        for (rows, columns) in [(24, 24), (60, 10), (5, 30)] {
            let d = random(rows, columns, 11);
            for order in [UpdateOrder::SparseFirst, UpdateOrder::LowRankFirst] {
                for iterations in [1, 2, 3, 7, 20] {
                    let settings = AlmSettings { iterations, order, lambda: 1.5, tolerance: 0.0 };
                    let (a, e) = twin(&d, &settings);
                    let ours = inexact_alm(&d, &settings);
                    assert_eq!(ours.iterations, iterations);
                    assert!((ours.low_rank - a).amax() < 1e-5, "A after {iterations}");
                    assert!((ours.sparse - e).amax() < 1e-5, "E after {iterations}");
                }
            }
        }
    }

    #[test]
    fn a_planted_decomposition_is_recovered_and_iteration_stops_early() {
        let (rows, columns) = (60, 50);
        let low_rank = random(rows, 3, 1) * random(3, columns, 2);
        let mut noise = TestNoise(9);
        let sparse = DMatrix::from_fn(rows, columns, |_, _| match noise.uniform() {
            u if u < 0.05 => 100.0 * noise.normal(),
            _ => 0.0,
        });
        let settings = AlmSettings { iterations: 200, ..AlmSettings::default() };
        for order in [UpdateOrder::SparseFirst, UpdateOrder::LowRankFirst] {
            let alm = inexact_alm(&(&low_rank + &sparse), &AlmSettings { order, ..settings });
            assert!(alm.iterations < 100, "{} iterations", alm.iterations);
            assert!((&alm.low_rank - &low_rank).norm() < 1e-4 * low_rank.norm());
            assert!((&alm.sparse - &sparse).norm() < 1e-4 * sparse.norm());
        }
    }

    #[test]
    fn parts_scale_with_the_matrix_however_large_or_small() {
        let d = random(12, 9, 4);
        let settings = AlmSettings { iterations: 5, ..AlmSettings::default() };
        let plain = inexact_alm(&d, &settings);
        for factor in [1e-250, 1e250] {
            let scaled = inexact_alm(&(&d * factor), &settings);
            assert!((scaled.sparse / factor - &plain.sparse).amax() < 1e-9);
            assert!((scaled.low_rank / factor - &plain.low_rank).amax() < 1e-9);
        }
    }

    #[test]
    fn zero_empty_single_and_broken_matrices_are_no_exception() {
        let settings = AlmSettings { iterations: 30, ..AlmSettings::default() };
        for (rows, columns) in [(0, 0), (0, 4), (1, 1), (8, 3)] {
            let zero = DMatrix::zeros(rows, columns);
            let alm = inexact_alm(&zero, &settings);
            assert_eq!((alm.low_rank, alm.sparse), (zero.clone(), zero));
        }
        // λ = 1 for a single entry, so that both parts cost the same; only their sum is determined.
        let one = inexact_alm(&DMatrix::from_element(1, 1, 5.0), &settings);
        assert!((one.low_rank[0] + one.sparse[0] - 5.0).abs() < 1e-5);

        let mut broken = random(8, 8, 5);
        broken[(2, 3)] = 0.0;
        let mended = inexact_alm(&broken, &settings);
        for bad in [f64::NAN, f64::INFINITY] {
            broken[(2, 3)] = bad;
            assert_eq!(inexact_alm(&broken, &settings), mended);
        }
    }
}
