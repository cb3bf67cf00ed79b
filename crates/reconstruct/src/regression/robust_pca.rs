//! Robust principal component analysis of the features in a window (eq. 9), by the inexact augmented Lagrangian
//! method of Lin et al. 2010.
//!
//! With X = D − E + Y/μ, the low-rank step is A = X Σ max(0, 1 − 1/(μσ_j)) v_j v_jᵀ, which needs the eigenvectors of XᵀX
//! only, and the multiplier after it is Y/μ = X − A. So an iteration is one walk over the rows (multiply by two small
//! matrices, clip, add to a Gram matrix) and one small eigenproblem; no singular vectors of the tall side and no Y are
//! ever formed.

use std::ops::Range;

use pulp::Simd;

use super::lanes::{Lanes, Mask};
use super::matrix::{add_gram, multiply};
use super::power_iteration::largest_eigenvalue;
use super::symmetric_eigen::Eigen;

stack::knob_choice! {
    /// Which of the two unknowns an iteration updates first.
    pub enum Order {
        /// The sparse part E, then the low-rank part A.
        SparseFirst = "e-first",
        /// The low-rank part A, then the sparse part E.
        LowRankFirst = "a-first",
    }
}

stack::knob_choice! {
    /// Weight λ of the sparse part of an n × d matrix.
    pub enum Lambda {
        /// 1/√max(n, d).
        LongestSide = "longest-side",
        /// 3/√n.
        ThreeOverRoot = "three-over-root",
        /// 1/√d.
        ShortestSide = "shortest-side",
    }
}

/// What the multipliers' weight μ grows by in each iteration.
const GROWTH: f32 = 1.5;
/// Inverse of the first μ, in units of ‖D‖₂.
const FIRST_THRESHOLD: f32 = 0.8;
/// Eigenvectors of XᵀX are found to within this share of the squared threshold: what stays mixed moves A by at most half
/// as much.
const RESOLUTION: f32 = 1e-3;
/// Rows worked on between two updates of the Gram matrix: few enough to stay in the nearest cache.
const BLOCK: usize = 12;

/// What [`RobustPca::decompose`] needs to know beside its matrix.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Schedule {
    pub(crate) iterations: usize,
    pub(crate) tolerance: f32,
    pub(crate) order: Order,
    pub(crate) lambda: Lambda,
}

/// A matrix D, its decomposition, and the room to find it in.
#[derive(Debug)]
pub(crate) struct RobustPca<S: Simd> {
    simd: S,
    width: usize,
    /// D, in rows of `width` numbers, as many as a multiple of 4.
    pub(crate) data: Vec<Lanes<S>>,
    /// Singular values of A, in the order of `vectors`.
    pub(crate) singular: Vec<Lanes<S>>,
    /// Singular values of the X that A was shrunk from: positive for every direction D has.
    pub(crate) strengths: Vec<Lanes<S>>,
    /// Row j is right singular vector j.
    pub(crate) vectors: Vec<Lanes<S>>,
    /// ‖E‖₂.
    pub(crate) error_norm: Lanes<S>,
    target: Vec<Lanes<S>>,
    sparse: Vec<Lanes<S>>,
    low: Vec<Lanes<S>>,
    /// Indices of the directions that the low-rank step keeps, and how much of each.
    kept: Vec<usize>,
    factors: Vec<Lanes<S>>,
    /// V_r, f V_rᵀ, and X·V_r.
    onto: Vec<Lanes<S>>,
    back: Vec<Lanes<S>>,
    coordinates: Vec<Lanes<S>>,
    gram: Vec<Lanes<S>>,
    eigen: Eigen<S>,
}

impl<S: Simd> RobustPca<S> {
    /// Room for matrices of up to `rows` × `width`.
    pub(crate) fn with_capacity(simd: S, rows: usize, width: usize) -> Self {
        let zeros = |n| vec![Lanes::splat(simd, 0.0); n];
        Self {
            simd,
            width: 0,
            data: Vec::with_capacity(rows.next_multiple_of(4) * width),
            singular: zeros(width),
            strengths: zeros(width),
            vectors: zeros(width * width),
            error_norm: Lanes::splat(simd, 0.0),
            target: Vec::with_capacity(rows.next_multiple_of(4) * width),
            sparse: Vec::with_capacity(rows.next_multiple_of(4) * width),
            low: zeros(BLOCK * width),
            kept: Vec::with_capacity(width),
            factors: zeros(width),
            onto: zeros(width * width),
            back: zeros(width * width),
            coordinates: zeros(BLOCK * width),
            gram: zeros(width * width),
            eigen: Eigen::with_capacity(simd, width),
        }
    }

    /// Says what [`Self::data`] holds: rows of `width` numbers, of which the first `labels.len()` are the columns
    /// `labels` of a matrix of `all` columns whose other columns are zero.
    #[inline(always)]
    fn begin(&mut self, width: usize, labels: &[usize], all: usize) {
        self.width = width;
        let zero = Lanes::splat(self.simd, 0.0);
        self.singular.fill(zero);
        self.strengths.fill(zero);
        self.vectors.fill(zero);
        self.eigen.start(width, labels, all);
        self.clear_gram();
        add_gram(self.simd, &mut self.gram[..width * width], &self.data, width);
        self.eigen.solve(&self.gram[..width * width], zero);
    }

    /// The plain singular value decomposition of D, for comparison: A = D, and nothing is known about E.
    #[inline(always)]
    pub(crate) fn keep_all(&mut self, width: usize, labels: &[usize], all: usize) {
        self.begin(width, labels, all);
        let everywhere = Lanes::splat(self.simd, 0.0).equals(Lanes::splat(self.simd, 0.0));
        self.record(Lanes::splat(self.simd, 0.0), everywhere);
        self.error_norm = Lanes::splat(self.simd, 0.0);
    }

    /// Splits D, see [`Self::begin`], `rows` of whose rows are not padding.
    ///
    /// A lane that has converged is left as it is while others go on. When an iteration that updates E first stops
    /// early, E is the one of half a step later.
    #[inline(always)]
    pub(crate) fn decompose(&mut self, width: usize, labels: &[usize], all: usize, rows: Lanes<S>, schedule: Schedule) {
        self.begin(width, labels, all);
        let (spectral, frobenius) = self.norms_of_data();
        let lambda = self.lambda(rows, all, schedule.lambda);
        let mut threshold = spectral * FIRST_THRESHOLD;
        self.set_first_target(spectral, lambda, threshold, schedule.order);

        let mut running = Lanes::splat(self.simd, 0.0).less_than(spectral);
        for iteration in 1..=schedule.iterations {
            self.eigen.solve(&self.gram[..width * width], threshold.squared() * RESOLUTION);
            self.record(threshold, running);
            if iteration == schedule.iterations && schedule.order == Order::SparseFirst {
                break;
            }
            self.find_shrink(threshold);
            let residual = self.update(schedule.order, lambda * threshold, running);
            running = running.and((frobenius * schedule.tolerance).less_than(residual));
            if !running.any() {
                break;
            }
            threshold = threshold * (1.0 / GROWTH);
        }
        self.find_error_norm();
    }

    /// ‖D‖₂ and ‖D‖_F.
    #[inline(always)]
    fn norms_of_data(&self) -> (Lanes<S>, Lanes<S>) {
        let (mut largest, mut sum) = (Lanes::splat(self.simd, 0.0), Lanes::splat(self.simd, 0.0));
        for value in &self.eigen.values[..self.width] {
            largest = largest.max(*value);
            sum += *value;
        }
        (largest.sqrt(), sum.sqrt())
    }

    #[inline(always)]
    fn lambda(&self, rows: Lanes<S>, columns: usize, lambda: Lambda) -> Lanes<S> {
        let columns = Lanes::splat(self.simd, columns as f32);
        let rows = rows.max(Lanes::splat(self.simd, 1.0));
        match lambda {
            Lambda::LongestSide => Lanes::splat(self.simd, 1.0) / rows.max(columns).sqrt(),
            Lambda::ThreeOverRoot => Lanes::splat(self.simd, 3.0) / rows.sqrt(),
            Lambda::ShortestSide => Lanes::splat(self.simd, 1.0) / columns.sqrt(),
        }
    }

    /// X and E before the first low-rank step, and the Gram matrix of X. Y₀ = D/max(‖D‖₂, ‖D‖∞/λ), A₀ = E₀ = 0, so
    /// D + Y₀/μ₀ = c·D.
    #[inline(always)]
    fn set_first_target(&mut self, spectral: Lanes<S>, lambda: Lanes<S>, threshold: Lanes<S>, order: Order) {
        let zero = Lanes::splat(self.simd, 0.0);
        let mut largest = zero;
        for value in &self.data {
            largest = largest.max(value.abs());
        }
        let c = threshold * spectral.max(largest / lambda).reciprocal_or_zero() + 1.0;
        self.target.resize(self.data.len(), zero);
        self.sparse.resize(self.data.len(), zero);
        for ((d, x), e) in self.data.iter().zip(&mut self.target).zip(&mut self.sparse) {
            let scaled = *d * c;
            *x = if order == Order::SparseFirst { scaled.clip(lambda * threshold) } else { scaled };
            *e = scaled - *x;
        }
        self.clear_gram();
        add_gram(self.simd, &mut self.gram[..self.width * self.width], &self.target, self.width);
    }

    #[inline(always)]
    fn clear_gram(&mut self) {
        self.gram[..self.width * self.width].fill(Lanes::splat(self.simd, 0.0));
    }

    /// Notes the singular values and vectors of the present A in the lanes that still run.
    #[inline(always)]
    fn record(&mut self, threshold: Lanes<S>, running: Mask<S>) {
        for j in 0..self.width {
            let strength = self.eigen.values[j].sqrt();
            self.strengths[j] = running.select(strength, self.strengths[j]);
            self.singular[j] = running.select((strength - threshold).positive_part(), self.singular[j]);
        }
        for (kept, found) in self.vectors[..self.width * self.width].iter_mut().zip(&self.eigen.vectors) {
            *kept = running.select(*found, *kept);
        }
    }

    /// Prepares the low-rank step A = X·V_r·(f V_rᵀ), where f_j = max(0, 1 − threshold/σ_j) and V_r holds the
    /// directions in which f is positive in any lane.
    #[inline(always)]
    fn find_shrink(&mut self, threshold: Lanes<S>) {
        let (n, zero) = (self.width, Lanes::splat(self.simd, 0.0));
        self.kept.clear();
        for j in 0..n {
            let strength = self.eigen.values[j].sqrt();
            self.factors[j] = (strength - threshold).positive_part() * strength.reciprocal_or_zero();
            if zero.less_than(self.factors[j]).any() {
                self.kept.push(j);
            }
        }
        self.pad_kept();
        let rank = self.kept.len();
        for (place, j) in self.kept.iter().enumerate() {
            for i in 0..n {
                let value = self.eigen.vectors[j * n + i];
                self.onto[i * rank + place] = value;
                self.back[place * n + i] = value * self.factors[*j];
            }
        }
    }

    /// Adds directions that are not kept, of factor zero, until their number is even and not zero.
    #[inline(always)]
    fn pad_kept(&mut self) {
        for j in 0..self.width {
            let complete = self.kept.len().is_multiple_of(2) && !self.kept.is_empty();
            if !complete && !self.kept.contains(&j) {
                self.kept.push(j);
            }
        }
    }

    /// A, for a block of the rows of X.
    #[inline(always)]
    fn shrink(&mut self, block: Range<usize>) {
        let (simd, n, rank) = (self.simd, self.width, self.kept.len());
        let target = &self.target[block];
        let low = &mut self.low[..target.len()];
        let coordinates = &mut self.coordinates[..target.len() / n * rank];
        multiply(simd, coordinates, target, n, &self.onto[..n * rank], rank);
        multiply(simd, low, coordinates, rank, &self.back[..rank * n], n);
    }

    /// The walk over the rows: A from X, then E, then the next X and its Gram matrix. `limit` is λ/μ. Returns
    /// ‖D − A − E‖_F.
    #[inline(always)]
    fn update(&mut self, order: Order, limit: Lanes<S>, running: Mask<S>) -> Lanes<S> {
        let (width, simd) = (self.width, self.simd);
        let mut residual = Lanes::splat(simd, 0.0);
        let moving = running.select(Lanes::splat(simd, 1.0), residual);
        self.clear_gram();
        for start in (0..self.data.len()).step_by(BLOCK * width) {
            let block = start..(start + BLOCK * width).min(self.data.len());
            self.shrink(block.clone());
            let rows = Rows {
                data: &self.data[block.clone()],
                low: &self.low[..block.len()],
                target: &mut self.target[block.clone()],
                sparse: &mut self.sparse[block.clone()],
            };
            residual += match order {
                Order::SparseFirst => rows.update_sparse_first(simd, limit * (1.0 / GROWTH), moving),
                Order::LowRankFirst => rows.update_low_rank_first(simd, limit, moving),
            };
            add_gram(simd, &mut self.gram[..width * width], &self.target[block], width);
        }
        residual.sqrt()
    }

    #[inline(always)]
    fn find_error_norm(&mut self) {
        let n = self.width;
        self.clear_gram();
        add_gram(self.simd, &mut self.gram[..n * n], &self.sparse, n);
        self.error_norm = largest_eigenvalue(self.simd, &self.gram[..n * n], n, &mut self.low).positive_part().sqrt();
    }
}

/// Some rows of the matrices after a low-rank step, all of the same length.
struct Rows<'a, S: Simd> {
    /// D.
    data: &'a [Lanes<S>],
    /// A, new.
    low: &'a [Lanes<S>],
    /// X, which is made anew.
    target: &'a mut [Lanes<S>],
    /// E, which moves where its lanes still run.
    sparse: &'a mut [Lanes<S>],
}

impl<S: Simd> Rows<'_, S> {
    /// Y/μ = X − A with the grown μ, E = S(D − A + Y/μ), X = D − E + Y/μ. Returns Σ (D − A − E)² with the E that A was
    /// computed from.
    #[inline(always)]
    fn update_sparse_first(self, simd: S, limit: Lanes<S>, moving: Lanes<S>) -> Lanes<S> {
        let mut residual = Lanes::splat(simd, 0.0);
        for (((d, a), x), e) in self.data.iter().zip(self.low).zip(self.target).zip(self.sparse) {
            let rest = *d - *a;
            residual += (rest - *e).squared();
            let open = rest + (*x - *a) * (1.0 / GROWTH);
            let clipped = open.clip(limit);
            *e += (open - clipped - *e) * moving;
            *x = *a + clipped;
        }
        residual
    }

    /// E = S(D − A + Y/μ), then Y/μ = D − A + Y/μ − E, and with the grown μ X = D − E + Y/μ. Returns Σ (D − A − E)².
    #[inline(always)]
    fn update_low_rank_first(self, simd: S, limit: Lanes<S>, moving: Lanes<S>) -> Lanes<S> {
        let mut residual = Lanes::splat(simd, 0.0);
        for (((d, a), x), e) in self.data.iter().zip(self.low).zip(self.target).zip(self.sparse) {
            let open = *x - *a + *e;
            let clipped = open.clip(limit);
            let shrunk = open - clipped;
            residual += (*d - *a - shrunk).squared();
            *e += (shrunk - *e) * moving;
            *x = *d - shrunk + clipped * (1.0 / GROWTH);
        }
        residual
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use pulp::Scalar;

    use super::super::twin::{Random, exact_alm, lambda_of};
    use super::*;

    const LABELS: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9];

    /// A window as one meets it: two strong directions, one weak, an edge in a corner, a few outliers, some noise.
    fn window(seed: u64) -> DMatrix<f64> {
        let mut random = Random(seed);
        let mix = DMatrix::from_fn(4, 10, |i, _| f64::from(random.normal()) * [0.5, 0.3, 0.1, 0.6][i]);
        let shape = DMatrix::from_fn(121, 4, |row, i| {
            let (x, y) = ((row % 11) as f64 / 5.0 - 1.0, (row / 11) as f64 / 5.0 - 1.0);
            [x, y, x * y, if x + y > 0.9 { 1.0 } else { 0.0 }][i]
        });
        let spikes =
            DMatrix::from_fn(121, 10, |_, _| f64::from(if random.next() < 0.02 { random.normal() } else { 0.0 }));
        let noise = DMatrix::from_fn(121, 10, |_, _| 0.01 * f64::from(random.normal()));
        shape * mix + spikes + noise
    }

    fn load(data: &DMatrix<f64>) -> RobustPca<Scalar> {
        let mut pca = RobustPca::with_capacity(Scalar, data.nrows(), 10);
        pca.data = data.transpose().iter().map(|v| Lanes::splat(Scalar, *v as f32)).collect();
        pca.data.resize(124 * 10, Lanes::splat(Scalar, 0.0));
        pca
    }

    /// Compares singular values, the projector on the directions kept, and ‖E‖₂ with the twin's.
    fn assert_agrees(data: &DMatrix<f64>, schedule: Schedule) {
        let mut pca = load(data);
        let rows = Lanes::splat(Scalar, 121.0);
        pca.decompose(10, &LABELS, 10, rows, schedule);
        let lambda = lambda_of(schedule.lambda, 121, 10);
        let exact = exact_alm(data, schedule.iterations, schedule.tolerance.into(), schedule.order, lambda);
        let largest = data.clone().svd(false, false).singular_values.max();
        let mut found: Vec<(f32, usize)> = (0..10).map(|j| (pca.singular[j].to_array()[0], j)).collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (i, (singular, j)) in found.iter().enumerate() {
            assert!((f64::from(*singular) - exact.singular[i]).abs() < 2e-4 * largest, "{schedule:?}");
            let apart =
                |other: usize| exact.singular.get(other).is_none_or(|s| (s - exact.singular[i]).abs() > 0.1 * largest);
            if exact.singular[i] > 0.0 && apart(i + 1) && apart(i.wrapping_sub(1)) {
                let cosine: f64 =
                    (0..10).map(|f| exact.vectors[(f, i)] * f64::from(pca.vectors[j * 10 + f].to_array()[0])).sum();
                assert!(cosine.abs() > 0.9999, "{schedule:?}: direction {i}, {cosine}");
            }
        }
        let exact = exact.sparse.svd(false, false).singular_values.max();
        let error = f64::from(pca.error_norm.to_array()[0]);
        assert!((0.96 * exact - 1e-4..=1.003 * exact + 1e-4).contains(&error), "{schedule:?}: {error} for {exact}");
    }

    #[test]
    fn agrees_with_exact_singular_value_decompositions() {
        for order in [Order::SparseFirst, Order::LowRankFirst] {
            for lambda in [Lambda::LongestSide, Lambda::ThreeOverRoot, Lambda::ShortestSide] {
                for (iterations, tolerance) in [(1, 0.0), (2, 0.0), (10, 1e-3), (10, 0.05), (20, 0.0)] {
                    for seed in [1, 2] {
                        assert_agrees(&window(seed), Schedule { iterations, tolerance, order, lambda });
                    }
                }
            }
        }
    }

    #[test]
    fn a_matrix_of_zeros_has_no_singular_values() {
        let mut pca = load(&DMatrix::zeros(121, 10));
        let schedule =
            Schedule { iterations: 10, tolerance: 1e-3, order: Order::SparseFirst, lambda: Lambda::LongestSide };
        pca.decompose(10, &LABELS, 10, Lanes::splat(Scalar, 121.0), schedule);
        assert!(pca.singular.iter().all(|s| s.to_array()[0] == 0.0));
        assert_eq!(pca.error_norm.to_array()[0], 0.0);
    }

    #[test]
    fn low_rank_and_sparse_parts_are_told_apart() {
        let mut random = Random(4);
        let factors = (DMatrix::from_fn(121, 2, |_, _| f64::from(random.normal())), random_mix(&mut random));
        let low = &factors.0 * &factors.1;
        let mut data = low.clone();
        for _ in 0..40 {
            let at = ((random.next() * 121.0) as usize, (random.next() * 10.0) as usize);
            data[at] += 8.0 * f64::from(random.normal());
        }
        let mut pca = load(&data);
        let (order, lambda) = (Order::SparseFirst, Lambda::ThreeOverRoot);
        let schedule = Schedule { iterations: 30, tolerance: 1e-6, order, lambda };
        pca.decompose(10, &LABELS, 10, Lanes::splat(Scalar, 121.0), schedule);
        let mut found: Vec<f32> = pca.singular.iter().map(|s| s.to_array()[0]).collect();
        found.sort_by(|a, b| b.total_cmp(a));
        let exact = low.svd(false, false).singular_values;
        assert!((0..2).all(|i| (f64::from(found[i]) / exact[i] - 1.0).abs() < 0.02), "{found:?} for {exact}");
        assert!(found[2] < 0.01 * found[0], "{found:?}");
    }

    fn random_mix(random: &mut Random) -> DMatrix<f64> {
        DMatrix::from_fn(2, 10, |_, _| f64::from(random.normal()))
    }
}
