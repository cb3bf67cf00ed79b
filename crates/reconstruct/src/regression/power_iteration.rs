//! The largest eigenvalue of a small symmetric matrix, when nothing else about it is wanted.

use pulp::Simd;

use super::lanes::Lanes;

/// Steps taken. The value is too small by a few percent at most, when the next eigenvalue is that close.
const STEPS: usize = 16;

/// The largest eigenvalue of a positive semi-definite `matrix` (upper triangle, `size` rows), never overestimated.
/// `room` holds at least twice `size` numbers.
#[inline(always)]
pub(crate) fn largest_eigenvalue<S: Simd>(
    simd: S,
    matrix: &[Lanes<S>],
    size: usize,
    room: &mut [Lanes<S>],
) -> Lanes<S> {
    let (vector, image) = room[..2 * size].split_at_mut(size);
    start_from_largest_column(simd, matrix, vector);
    let mut value = Lanes::splat(simd, 0.0);
    for _ in 0..STEPS {
        normalise(simd, vector);
        value = multiply(simd, matrix, vector, image);
        vector.copy_from_slice(image);
    }
    value
}

/// Entry i, j of a matrix known by its upper triangle.
#[inline(always)]
fn entry<S: Simd>(matrix: &[Lanes<S>], size: usize, i: usize, j: usize) -> Lanes<S> {
    matrix[i.min(j) * size + i.max(j)]
}

/// The column with the largest diagonal entry: it cannot be orthogonal to every large eigenvector.
#[inline(always)]
fn start_from_largest_column<S: Simd>(simd: S, matrix: &[Lanes<S>], vector: &mut [Lanes<S>]) {
    let size = vector.len();
    let mut largest = Lanes::splat(simd, 0.0);
    vector.fill(largest);
    for j in 0..size {
        let diagonal = entry(matrix, size, j, j);
        let better = largest.less_than(diagonal);
        largest = better.select(diagonal, largest);
        for i in 0..size {
            vector[i] = better.select(entry(matrix, size, i, j), vector[i]);
        }
    }
}

#[inline(always)]
fn normalise<S: Simd>(simd: S, vector: &mut [Lanes<S>]) {
    let mut norm = Lanes::splat(simd, 0.0);
    for value in vector.iter() {
        norm += value.squared();
    }
    let scale = norm.sqrt().reciprocal_or_zero();
    for value in vector {
        *value = *value * scale;
    }
}

/// Writes the matrix times `vector` to `image`; returns their dot product, the Rayleigh quotient of a unit vector.
#[inline(always)]
fn multiply<S: Simd>(simd: S, matrix: &[Lanes<S>], vector: &[Lanes<S>], image: &mut [Lanes<S>]) -> Lanes<S> {
    let size = vector.len();
    let mut product = Lanes::splat(simd, 0.0);
    for i in 0..size {
        image[i] = Lanes::splat(simd, 0.0);
        for j in 0..size {
            image[i] += entry(matrix, size, i, j) * vector[j];
        }
        product += image[i] * vector[i];
    }
    product
}

#[cfg(test)]
mod tests {
    use super::super::lanes::MOST_LANES;
    use super::super::symmetric_eigen::tests::{N, SIMD, gram_matrices};
    use super::super::twin::Random;
    use super::*;

    #[test]
    fn agrees_with_nalgebra() {
        let (exact, lanes) = gram_matrices(&mut Random(11));
        let mut room = vec![Lanes::splat(SIMD, 0.0); 2 * N];
        let found = largest_eigenvalue(SIMD, &lanes, N, &mut room).to_array();
        for (matrix, found) in exact.iter().zip(found) {
            let ratio = f64::from(found) / matrix.symmetric_eigenvalues().max();
            assert!((0.97..1.00001).contains(&ratio), "{ratio}");
        }
    }

    #[test]
    fn nothing_comes_from_nothing() {
        let zeros = vec![Lanes::splat(SIMD, 0.0); N * N];
        let mut room = vec![zeros[0]; 2 * N];
        assert_eq!(largest_eigenvalue(SIMD, &zeros, N, &mut room).to_array(), [0.0; MOST_LANES]);
    }
}
