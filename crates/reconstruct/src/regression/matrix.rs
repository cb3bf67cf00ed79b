//! Products of tall, thin matrices, the bulk of the regression's arithmetic.
//!
//! Matrices are row-major. Widths are even, so that tiles of two columns cover them; callers pad with zeros, which
//! change no sum. A tile keeps its sums in registers while it walks down the rows.

use pulp::Simd;

use super::lanes::Lanes;

/// Adds XᵀX to `gram`, where X is `rows`, cut into rows of `columns` numbers.
///
/// Only the upper triangle of `gram` (`columns` × `columns`) is meant to be read afterwards.
#[inline(always)]
pub(crate) fn add_gram<S: Simd>(simd: S, gram: &mut [Lanes<S>], rows: &[Lanes<S>], columns: usize) {
    for i in (0..columns).step_by(2) {
        let mut j = i;
        while j < columns {
            j += match columns - j {
                6 | 10.. => add_gram_tile::<S, 6>(simd, gram, rows, columns, i, j),
                4.. => add_gram_tile::<S, 4>(simd, gram, rows, columns, i, j),
                _ => add_gram_tile::<S, 2>(simd, gram, rows, columns, i, j),
            };
        }
    }
}

/// The tile of rows i, i + 1 and columns j … j + `WIDTH` − 1; returns its width.
#[inline(always)]
fn add_gram_tile<S: Simd, const WIDTH: usize>(
    simd: S,
    gram: &mut [Lanes<S>],
    rows: &[Lanes<S>],
    columns: usize,
    i: usize,
    j: usize,
) -> usize {
    let mut sums = [[Lanes::splat(simd, 0.0); WIDTH]; 2];
    for row in rows.chunks_exact(columns) {
        let (left, right) = (&row[i..i + 2], &row[j..j + WIDTH]);
        for w in 0..WIDTH {
            sums[0][w] += left[0] * right[w];
            sums[1][w] += left[1] * right[w];
        }
    }
    for (below, sums) in sums.iter().enumerate() {
        let to = &mut gram[(i + below) * columns + j..][..WIDTH];
        for w in 0..WIDTH {
            to[w] += sums[w];
        }
    }
    WIDTH
}

/// Writes X·M to `product`, where X is `rows`, cut into rows of `inner` numbers, and `matrix` is M, `inner` × `columns`.
/// The number of rows is a multiple of 4.
#[inline(always)]
pub(crate) fn multiply<S: Simd>(
    simd: S,
    product: &mut [Lanes<S>],
    rows: &[Lanes<S>],
    inner: usize,
    matrix: &[Lanes<S>],
    columns: usize,
) {
    for (to, from) in product.chunks_exact_mut(4 * columns).zip(rows.chunks_exact(4 * inner)) {
        for j in (0..columns).step_by(2) {
            let tile = multiply_tile(simd, from, inner, &matrix[j..], columns);
            for (row, values) in tile.iter().enumerate() {
                to[row * columns + j] = values[0];
                to[row * columns + j + 1] = values[1];
            }
        }
    }
}

/// Four rows times the first two columns of `matrix`.
#[inline(always)]
fn multiply_tile<S: Simd>(
    simd: S,
    rows: &[Lanes<S>],
    inner: usize,
    matrix: &[Lanes<S>],
    columns: usize,
) -> [[Lanes<S>; 2]; 4] {
    let row = [&rows[..inner], &rows[inner..2 * inner], &rows[2 * inner..3 * inner], &rows[3 * inner..4 * inner]];
    let mut sums = [[Lanes::splat(simd, 0.0); 2]; 4];
    for f in 0..inner {
        let pair = &matrix[f * columns..][..2];
        for r in 0..4 {
            sums[r][0] += row[r][f] * pair[0];
            sums[r][1] += row[r][f] * pair[1];
        }
    }
    sums
}
