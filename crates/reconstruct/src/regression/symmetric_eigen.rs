//! Eigenvalues and eigenvectors of small symmetric matrices, by Jacobi rotations (Golub and Van Loan, *Matrix
//! Computations*, section 8.5).

use std::ops::Range;

use pulp::Simd;

use super::lanes::Lanes;
use super::matrix::multiply;

/// An off-diagonal entry is left alone when it is at most this times the trace: a few roundings of the Gram matrix.
const NEGLIGIBLE: f32 = 4e-7;
/// Bound on sweeps; from scratch 10 × 10 matrices take four or five, from neighbouring eigenvectors one or two.
const MOST_SWEEPS: usize = 8;

/// Eigenvalues and eigenvectors, and the room to find them in.
#[derive(Debug)]
pub(crate) struct Eigen<S: Simd> {
    simd: S,
    size: usize,
    /// Eigenvalues, in no particular order.
    pub(crate) values: Vec<Lanes<S>>,
    /// Row j is the unit eigenvector of value j.
    pub(crate) vectors: Vec<Lanes<S>>,
    /// M in the basis of the vectors; rotations keep its upper triangle only.
    rotated: Vec<Lanes<S>>,
    whole: Vec<Lanes<S>>,
    half: Vec<Lanes<S>>,
    /// All pairs of rows, in rounds of disjoint pairs.
    order: Vec<(usize, usize)>,
    rounds: Vec<Range<usize>>,
    turns: Vec<Rotation<S>>,
}

impl<S: Simd> Eigen<S> {
    /// Room for matrices up to `most` × `most`.
    pub(crate) fn with_capacity(simd: S, most: usize) -> Self {
        let zeros = |n| vec![Lanes::splat(simd, 0.0); n];
        let [vectors, rotated, whole, half] = [0; 4].map(|_| zeros(most * most));
        let (order, rounds, turns) = (Vec::with_capacity(most * most), Vec::new(), Vec::with_capacity(most));
        Self { simd, size: 0, values: zeros(most), vectors, rotated, whole, half, order, rounds, turns }
    }

    /// Starts a series of similar matrices of `size` rows, the first of which is close to nothing known.
    ///
    /// `labels` names the rows among `all`; pairs are rotated in an order that depends on the labels only, so a row of
    /// zeros may be left out without changing a byte of the others.
    #[inline(always)]
    pub(crate) fn start(&mut self, size: usize, labels: &[usize], all: usize) {
        self.size = size;
        for i in 0..size {
            for j in 0..size {
                self.vectors[i * size + j] = Lanes::splat(self.simd, if i == j { 1.0 } else { 0.0 });
            }
        }
        // Pairs of equal sum are disjoint: their angles can be found together.
        self.order.clear();
        self.rounds.clear();
        for sum in 0..all {
            let first = self.order.len();
            for (p, a) in labels.iter().enumerate() {
                for (q, b) in labels.iter().enumerate().skip(p + 1) {
                    if (a + b) % all == sum {
                        self.order.push((p, q));
                    }
                }
            }
            self.rounds.push(first..self.order.len());
        }
    }

    /// Solves for `matrix` (upper triangle), starting from the eigenvectors found last. Off-diagonal entries of at most
    /// `resolution` may remain.
    #[inline(always)]
    pub(crate) fn solve(&mut self, matrix: &[Lanes<S>], resolution: Lanes<S>) {
        self.rotate_into_last_basis(matrix);
        let size = self.size;
        let mut trace = Lanes::splat(self.simd, 0.0);
        for i in 0..size {
            trace += self.rotated[i * size + i];
        }
        for _ in 0..MOST_SWEEPS {
            if !self.sweep(resolution.max(trace * NEGLIGIBLE)) {
                break;
            }
        }
        for i in 0..size {
            self.values[i] = self.rotated[i * size + i].positive_part();
        }
    }

    /// V M Vᵀ, V's rows being the last eigenvectors.
    #[inline(always)]
    fn rotate_into_last_basis(&mut self, matrix: &[Lanes<S>]) {
        let n = self.size;
        for i in 0..n {
            for j in i..n {
                self.whole[i * n + j] = matrix[i * n + j];
                self.whole[j * n + i] = matrix[i * n + j];
            }
        }
        multiply(self.simd, &mut self.half[..n * n], &self.vectors[..n * n], n, &self.whole[..n * n], n);
        for i in 0..n {
            for j in 0..n {
                self.whole[j * n + i] = self.vectors[i * n + j];
            }
        }
        multiply(self.simd, &mut self.rotated[..n * n], &self.half[..n * n], n, &self.whole[..n * n], n);
    }

    /// Rotates every pair whose entry is larger than `negligible`; says whether there was one.
    #[inline(always)]
    fn sweep(&mut self, negligible: Lanes<S>) -> bool {
        let mut any = false;
        for round in 0..self.rounds.len() {
            self.turns.clear();
            for index in self.rounds[round].clone() {
                let (p, q) = self.order[index];
                let entry = self.rotated[p * self.size + q];
                let needed = negligible.less_than(entry.abs());
                if needed.any() {
                    let entry = needed.select(entry, Lanes::splat(self.simd, 0.0));
                    let gap = self.rotated[q * self.size + q] - self.rotated[p * self.size + p];
                    self.turns.push(Rotation::new(self.simd, (p, q), gap, entry));
                }
            }
            for index in 0..self.turns.len() {
                any = true;
                self.rotate(self.turns[index]);
            }
        }
        any
    }

    /// Rotates the two rows and columns of `turn`, so that their common entry vanishes.
    #[inline(always)]
    fn rotate(&mut self, turn: Rotation<S>) {
        let (n, p, q) = (self.size, turn.p, turn.q);
        self.rotated[p * n + p] = self.rotated[p * n + p] - turn.shift;
        self.rotated[q * n + q] += turn.shift;
        self.rotated[p * n + q] = self.rotated[p * n + q] - turn.entry;
        for r in 0..p {
            turn.apply(&mut self.rotated, r * n + p, r * n + q);
        }
        for r in p + 1..q {
            turn.apply(&mut self.rotated, p * n + r, r * n + q);
        }
        for r in q + 1..n {
            turn.apply(&mut self.rotated, p * n + r, q * n + r);
        }
        for r in 0..n {
            turn.apply(&mut self.vectors, p * n + r, q * n + r);
        }
    }
}

/// A rotation in the plane of rows p and q.
#[derive(Clone, Copy, Debug)]
struct Rotation<S: Simd> {
    p: usize,
    q: usize,
    /// What becomes zero.
    entry: Lanes<S>,
    /// By how much it moves the diagonal entries apart.
    shift: Lanes<S>,
    cosine: Lanes<S>,
    sine: Lanes<S>,
}

impl<S: Simd> Rotation<S> {
    /// The smaller of the two rotations that diagonalise a 2 × 2 block with the given `entry` beside the diagonal,
    /// whose diagonal entries differ by `gap`. Where the entry is 0 it rotates nothing.
    #[inline(always)]
    fn new(simd: S, (p, q): (usize, usize), gap: Lanes<S>, entry: Lanes<S>) -> Self {
        let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
        let twice = entry + entry;
        let root = (gap.squared() + twice.squared()).sqrt();
        let signed = gap.less_than(zero).select(zero - twice, twice);
        let tangent = signed / (gap.abs() + root).max(Lanes::splat(simd, f32::MIN_POSITIVE));
        let cosine = one / (tangent.squared() + 1.0).sqrt();
        Self { p, q, entry, shift: tangent * entry, cosine, sine: tangent * cosine }
    }

    #[inline(always)]
    fn apply(self, values: &mut [Lanes<S>], i: usize, j: usize) {
        let (a, b) = (values[i], values[j]);
        values[i] = self.cosine * a - self.sine * b;
        values[j] = self.sine * a + self.cosine * b;
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use nalgebra::DMatrix;
    use pulp::Scalar256b;

    use super::super::lanes::MOST_LANES;
    use super::super::twin::Random;
    use super::*;

    pub(crate) const N: usize = 10;
    pub(crate) const SIMD: Scalar256b = Scalar256b;

    /// Gram matrices, one per lane, whose eigenvalues fall off as they do in windows: some lanes have few directions.
    pub(crate) fn gram_matrices(random: &mut Random) -> (Vec<DMatrix<f64>>, Vec<Lanes<Scalar256b>>) {
        let matrices: Vec<DMatrix<f64>> = (0..8)
            .map(|lane| {
                let x = DMatrix::from_fn(40, N, |_, _| f64::from(random.normal()));
                let mix = DMatrix::from_fn(N, N, |i, _| f64::from(random.normal()) * 0.6f64.powi(i as i32 * lane / 2));
                let x = x * mix;
                x.transpose() * x
            })
            .collect();
        let lanes = (0..N * N)
            .map(|i| {
                let mut values = [0.0; MOST_LANES];
                for (value, matrix) in values.iter_mut().zip(&matrices) {
                    *value = matrix[(i / N, i % N)] as f32;
                }
                Lanes::load(SIMD, &values)
            })
            .collect();
        (matrices, lanes)
    }

    #[test]
    fn agrees_with_nalgebra_from_scratch_and_from_other_vectors() {
        let mut random = Random(3);
        let mut eigen = Eigen::with_capacity(SIMD, N);
        eigen.start(N, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9], N);
        for _ in 0..3 {
            let (exact, lanes) = gram_matrices(&mut random);
            eigen.solve(&lanes, Lanes::splat(SIMD, 0.0));
            for (lane, matrix) in exact.iter().enumerate() {
                let mut values: Vec<f64> = eigen.values[..N].iter().map(|v| v.to_array()[lane].into()).collect();
                let mut expected: Vec<f64> = matrix.symmetric_eigenvalues().iter().copied().collect();
                values.sort_by(f64::total_cmp);
                expected.sort_by(f64::total_cmp);
                assert!(values.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 3e-6 * matrix.trace()));
                let v = DMatrix::from_fn(N, N, |i, j| f64::from(eigen.vectors[i * N + j].to_array()[lane]));
                let off = &v * matrix * v.transpose();
                assert!((&v * v.transpose() - DMatrix::identity(N, N)).amax() < 2e-5);
                assert!((&off - DMatrix::from_diagonal(&off.diagonal())).amax() < 3e-6 * matrix.trace());
            }
        }
    }

    #[test]
    fn a_row_of_zeros_may_be_left_out() {
        let (_, mut full) = gram_matrices(&mut Random(5));
        let zero = Lanes::splat(SIMD, 0.0);
        for i in 0..N {
            for dropped in [4, 7] {
                full[i * N + dropped] = zero;
                full[dropped * N + i] = zero;
            }
        }
        let listed = [0, 1, 2, 3, 5, 6, 8, 9];
        let part: Vec<_> = listed.iter().flat_map(|i| listed.map(|j| full[i * N + j])).collect();
        let (mut all, mut few) = (Eigen::with_capacity(SIMD, N), Eigen::with_capacity(SIMD, N));
        all.start(N, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9], N);
        few.start(8, &listed, N);
        all.solve(&full, zero);
        few.solve(&part, zero);
        for (i, label) in listed.iter().enumerate() {
            assert_eq!(few.values[i].to_array(), all.values[*label].to_array());
        }
    }

    #[test]
    fn nothing_comes_from_nothing() {
        let zeros = vec![Lanes::splat(SIMD, 0.0); N * N];
        let mut eigen = Eigen::with_capacity(SIMD, N);
        eigen.start(N, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9], N);
        eigen.solve(&zeros, zeros[0]);
        assert!(eigen.values.iter().all(|v| v.to_array() == [0.0; MOST_LANES]));
    }
}
