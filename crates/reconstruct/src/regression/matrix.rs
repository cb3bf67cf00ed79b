//! Products of tall, thin matrices, the bulk of the regression's arithmetic.
//!
//! Matrices are row-major. Widths and numbers of rows are even; callers pad with zeros, which change no sum. A tile
//! keeps two rows' sums in registers while it walks along the dimension that is summed over.

use pulp::Simd;

use super::lanes::Lanes;

/// Width of the next tile when `rest` columns, an even number, remain: 6 and 4 keep the most sums in registers.
const fn tile_width(rest: usize) -> usize {
    match rest {
        6 | 10.. => 6,
        4.. => 4,
        _ => 2,
    }
}

/// Adds XᵀX to `gram`, where X is `rows`, cut into rows of `columns` numbers.
///
/// Only the upper triangle of `gram` (`columns` × `columns`) is meant to be read afterwards.
#[inline(always)]
pub(crate) fn add_gram<S: Simd>(simd: S, gram: &mut [Lanes<S>], rows: &[Lanes<S>], columns: usize) {
    for i in (0..columns).step_by(2) {
        let mut j = i;
        while j < columns {
            let width = tile_width(columns - j);
            let to = &mut gram[i * columns + j..];
            match width {
                6 => add_gram_tile::<S, 6>(simd, to, rows, columns, i, j),
                4 => add_gram_tile::<S, 4>(simd, to, rows, columns, i, j),
                _ => add_gram_tile::<S, 2>(simd, to, rows, columns, i, j),
            }
            j += width;
        }
    }
}

/// The tile whose rows belong to columns i, i + 1 of X and whose columns to j … j + `WIDTH` − 1.
#[inline(always)]
fn add_gram_tile<S: Simd, const WIDTH: usize>(
    simd: S,
    gram: &mut [Lanes<S>],
    rows: &[Lanes<S>],
    columns: usize,
    i: usize,
    j: usize,
) {
    // Sums go on from where they were, so that they do not depend on where rows are cut into blocks.
    let mut sums: [[Lanes<S>; WIDTH]; 2] = [read_tile(simd, gram), read_tile(simd, &gram[columns..])];
    let mut start = 0;
    while start < rows.len() {
        let (left, right) = (&rows[start + i..][..2], &rows[start + j..][..WIDTH]);
        for w in 0..WIDTH {
            sums[0][w] += left[0] * right[w];
            sums[1][w] += left[1] * right[w];
        }
        start += columns;
    }
    gram[..WIDTH].copy_from_slice(&sums[0]);
    gram[columns..columns + WIDTH].copy_from_slice(&sums[1]);
}

#[inline(always)]
fn read_tile<S: Simd, const WIDTH: usize>(simd: S, from: &[Lanes<S>]) -> [Lanes<S>; WIDTH] {
    let mut tile = [Lanes::splat(simd, 0.0); WIDTH];
    tile.copy_from_slice(&from[..WIDTH]);
    tile
}

/// Writes X·M to `product`, where X is `rows`, cut into rows of `inner` numbers, and `matrix` is M, `inner` × `columns`.
#[inline(always)]
pub(crate) fn multiply<S: Simd>(
    simd: S,
    product: &mut [Lanes<S>],
    rows: &[Lanes<S>],
    inner: usize,
    matrix: &[Lanes<S>],
    columns: usize,
) {
    let mut start = 0;
    let mut to = 0;
    while start < rows.len() {
        let from = &rows[start..start + 2 * inner];
        let mut j = 0;
        while j < columns {
            let width = tile_width(columns - j);
            let to = &mut product[to + j..];
            match width {
                6 => multiply_tile::<S, 6>(simd, to, from, &matrix[j..], columns),
                4 => multiply_tile::<S, 4>(simd, to, from, &matrix[j..], columns),
                _ => multiply_tile::<S, 2>(simd, to, from, &matrix[j..], columns),
            }
            j += width;
        }
        start += 2 * inner;
        to += 2 * columns;
    }
}

/// Two rows of the product, the first `WIDTH` columns of `matrix`.
#[inline(always)]
fn multiply_tile<S: Simd, const WIDTH: usize>(
    simd: S,
    product: &mut [Lanes<S>],
    rows: &[Lanes<S>],
    matrix: &[Lanes<S>],
    columns: usize,
) {
    let mut sums = [[Lanes::splat(simd, 0.0); WIDTH]; 2];
    let (first, second) = rows.split_at(rows.len() / 2);
    for f in 0..first.len() {
        let factors = &matrix[f * columns..][..WIDTH];
        let (a, b) = (first[f], second[f]);
        for w in 0..WIDTH {
            sums[0][w] += a * factors[w];
            sums[1][w] += b * factors[w];
        }
    }
    product[..WIDTH].copy_from_slice(&sums[0]);
    product[columns..columns + WIDTH].copy_from_slice(&sums[1]);
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use pulp::Scalar;

    use super::super::twin::Random;
    use super::*;

    fn random_matrix(rows: usize, columns: usize) -> (DMatrix<f64>, Vec<Lanes<Scalar>>) {
        let mut random = Random((rows * 31 + columns) as u64);
        let matrix = DMatrix::from_fn(rows, columns, |_, _| f64::from(random.normal()));
        let lanes = matrix.transpose().iter().map(|v| Lanes::splat(Scalar, *v as f32)).collect();
        (matrix, lanes)
    }

    fn close(a: Lanes<Scalar>, b: f64) -> bool {
        (f64::from(a.to_array()[0]) - b).abs() < 1e-4
    }

    #[test]
    fn gram_matrices_agree_with_nalgebra_for_every_width() {
        for columns in (2..=22).step_by(2) {
            let (x, rows) = random_matrix(33, columns);
            let exact = x.transpose() * x;
            let mut gram = vec![Lanes::splat(Scalar, 0.0); columns * columns];
            add_gram(Scalar, &mut gram, &rows[..20 * columns], columns);
            add_gram(Scalar, &mut gram, &rows[20 * columns..], columns);
            for i in 0..columns {
                assert!((i..columns).all(|j| close(gram[i * columns + j], exact[(i, j)])), "width {columns}");
            }
        }
    }

    #[test]
    fn products_agree_with_nalgebra_for_every_width() {
        for (inner, columns) in (2..=16).step_by(2).flat_map(|i| [2, 4, 6, 8, 10, 14].map(|c| (i, c))) {
            let ((x, rows), (m, matrix)) = (random_matrix(6, inner), random_matrix(inner, columns));
            let exact = (x * m).transpose();
            let mut product = vec![Lanes::splat(Scalar, 0.0); 6 * columns];
            multiply(Scalar, &mut product, &rows, inner, &matrix, columns);
            assert!(product.iter().zip(exact.iter()).all(|(a, b)| close(*a, *b)), "{inner} x {columns}");
        }
    }
}
