//! Convolution of a plane with a short kernel, along its rows or its columns; edges are continued by their last pixel.

use rayon::prelude::*;
use stack::Size;

/// Weights at the offsets −radius … radius.
pub type Kernel = Vec<f32>;

/// A kernel with the value of `weight` at each whole offset from −`radius` to `radius`.
pub fn kernel(radius: usize, weight: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..=2 * radius).map(|i| weight(i as f64 - radius as f64)).collect()
}

/// The kernel in the precision it is used in, times `factor`.
pub fn scaled(kernel: &[f64], factor: f64) -> Kernel {
    kernel.iter().map(|weight| (weight * factor) as f32).collect()
}

/// Each pixel's weighted sum of its neighbours in the row.
pub fn along_rows(plane: &[f32], size: Size, kernel: &Kernel) -> Vec<f32> {
    let radius = kernel.len() / 2;
    let mut sums = vec![0.0; plane.len()];
    sums.par_chunks_mut(size.width).zip(plane.par_chunks(size.width)).for_each(|(sums, row)| {
        let mut continued = vec![row[0]; radius];
        continued.extend_from_slice(row);
        continued.resize(size.width + 2 * radius, row[size.width - 1]);
        for (offset, weight) in kernel.iter().enumerate() {
            add_weighted(sums, &continued[offset..], *weight);
        }
    });
    sums
}

/// Each pixel's weighted sum of its neighbours in the column.
pub fn along_columns(plane: &[f32], size: Size, kernel: &Kernel) -> Vec<f32> {
    let radius = kernel.len() / 2;
    let mut sums = vec![0.0; plane.len()];
    sums.par_chunks_mut(size.width).enumerate().for_each(|(y, sums)| {
        for (offset, weight) in kernel.iter().enumerate() {
            let row = (y + offset).saturating_sub(radius).min(size.height - 1);
            add_weighted(sums, &plane[row * size.width..], *weight);
        }
    });
    sums
}

fn add_weighted(sums: &mut [f32], values: &[f32], weight: f32) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += weight * value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_sum_with_edges_continued() {
        let size = Size::new(4, 3);
        let plane: Vec<f32> = (0..12).map(|i| ((i * i) % 7) as f32).collect();
        let weights = vec![0.5, -1.0, 2.0, 0.25, 3.0];
        let at = |x: i32, y: i32| plane[size.index(x.clamp(0, 3) as usize, y.clamp(0, 2) as usize)];
        let (rows, columns) = (along_rows(&plane, size, &weights), along_columns(&plane, size, &weights));
        for (i, (row, column)) in rows.iter().zip(&columns).enumerate() {
            let (x, y) = ((i % 4) as i32, (i / 4) as i32);
            let sum = |value: &dyn Fn(i32) -> f32| (0..5).map(|t| weights[t as usize] * value(t - 2)).sum::<f32>();
            assert_eq!((*row, *column), (sum(&|d| at(x + d, y)), sum(&|d| at(x, y + d))));
        }
    }

    #[test]
    fn a_kernel_is_centred() {
        assert_eq!(scaled(&kernel(2, |x| x), 0.5), [-1.0, -0.5, 0.0, 0.5, 1.0]);
    }
}
