//! Sums and means over square windows.
//!
//! Windows are summed anew for every pixel, by doubling, instead of being slid along: a sliding `f32` sum never forgets
//! a large value it has passed, and it does not vectorise.

use rayon::prelude::*;
use stack::Size;

/// Values that one task looks through.
const CHUNK: usize = 4096;

/// Sums of `width` consecutive values of `values`: `sums[i] = Σ values[i..i + width]`.
///
/// Pairs, fours, eights … are formed in `partial`, so that it takes about 2·log₂(width) additions a value. The order of
/// addition depends on `width` only.
///
/// # Panics
/// When `values` or `partial` is shorter than `sums.len() + width − 1`: that is a mistake in the calling code.
#[inline(always)]
pub fn window_sums(values: &[f32], width: usize, partial: &mut [f32], sums: &mut [f32]) {
    // Windows of patches are so narrow that nothing is gained by keeping partial sums.
    match width {
        3 => return narrow_sums::<3>(values, sums),
        5 => return narrow_sums::<5>(values, sums),
        7 => return narrow_sums::<7>(values, sums),
        _ => {}
    }
    let needed = sums.len() + width - 1;
    partial[..needed].copy_from_slice(&values[..needed]);
    sums.fill(0.0);
    let (mut done, mut span) = (0, 1);
    loop {
        if width & span != 0 {
            for (sum, part) in sums.iter_mut().zip(&partial[done..]) {
                *sum += part;
            }
            done += span;
        }
        if 2 * span > width {
            return;
        }
        for i in 0..needed - span {
            partial[i] += partial[i + span];
        }
        span *= 2;
    }
}

/// Sums of `W` consecutive values.
#[inline(always)]
fn narrow_sums<const W: usize>(values: &[f32], sums: &mut [f32]) {
    let count = sums.len();
    let mut shifted = [&values[..count]; W];
    for (shift, shifted) in shifted.iter_mut().enumerate() {
        *shifted = &values[shift..][..count];
    }
    for i in 0..count {
        let mut sum = shifted[0][i];
        for shifted in &shifted[1..] {
            sum += shifted[i];
        }
        sums[i] = sum;
    }
}

/// Mean over the (2·`radius` + 1)² window around every pixel of a row-major `plane`, as far as it lies inside the image.
/// NaN means *unknown* and is left out; a window of nothing else gives NaN.
///
/// # Panics
/// When `plane` does not hold `size.pixels()` values.
pub fn box_mean(plane: &[f32], size: Size, radius: usize) -> Vec<f32> {
    assert_eq!(plane.len(), size.pixels(), "a plane must cover the image");
    if plane.par_chunks(CHUNK).all(|part| part.iter().all(|v| !v.is_nan())) {
        return mean_of_known(plane, size, radius);
    }
    let known: Vec<f32> = plane.iter().map(|v| if v.is_nan() { 0.0 } else { 1.0 }).collect();
    let values: Vec<f32> = plane.iter().map(|v| if v.is_nan() { 0.0 } else { *v }).collect();
    let mut sums = box_sum(&values, size, radius);
    let counts = box_sum(&known, size, radius);
    for (sum, count) in sums.iter_mut().zip(&counts) {
        *sum = if *count > 0.0 { *sum / count } else { f32::NAN };
    }
    sums
}

/// Means of means over square windows: a smoother window, twice as wide.
pub fn box_mean_twice(plane: &[f32], size: Size, radius: usize) -> Vec<f32> {
    box_mean(&box_mean(plane, size, radius), size, radius)
}

/// [`box_mean`] where everything is known.
fn mean_of_known(plane: &[f32], size: Size, radius: usize) -> Vec<f32> {
    let inside = |at: usize, length: usize| ((at + radius + 1).min(length) - at.saturating_sub(radius)) as f32;
    let columns: Vec<f32> = (0..size.width).map(|x| inside(x, size.width)).collect();
    let mut sums = box_sum(plane, size, radius);
    sums.par_chunks_mut(size.width.max(1)).enumerate().for_each(|(y, row)| {
        let rows = inside(y, size.height);
        row.iter_mut().zip(&columns).for_each(|(sum, columns)| *sum /= rows * columns);
    });
    sums
}

/// Sum over the (2·`radius` + 1)² window around every pixel, as far as it lies inside the image.
fn box_sum(plane: &[f32], size: Size, radius: usize) -> Vec<f32> {
    let mut across = vec![0.0; size.pixels()];
    let mut sums = vec![0.0; size.pixels()];
    if size.pixels() == 0 {
        return sums;
    }
    across.par_chunks_mut(size.width).zip(plane.par_chunks(size.width)).for_each(|(out, row)| {
        row_sums(row, radius, out);
    });
    sums.par_chunks_mut(size.width).enumerate().for_each(|(y, out)| {
        for row in y.saturating_sub(radius)..(y + radius + 1).min(size.height) {
            for (sum, value) in out.iter_mut().zip(&across[row * size.width..]) {
                *sum += value;
            }
        }
    });
    sums
}

/// Sums over windows of one row, cut off at its ends.
fn row_sums(row: &[f32], radius: usize, out: &mut [f32]) {
    let mut padded = vec![0.0; row.len() + 2 * radius];
    padded[radius..radius + row.len()].copy_from_slice(row);
    let mut partial = vec![0.0; padded.len()];
    window_sums(&padded, 2 * radius + 1, &mut partial, out);
}

/// Gives every unknown (NaN) value of `plane` the mean of the known ones near it, taken from the finest level of a
/// pyramid of 2×2 means where there are any. Leaves a plane without any known value as it is.
pub fn fill_unknown(plane: &mut [f32], size: Size) {
    if size.pixels() <= 1 || !plane.iter().any(|v| v.is_nan()) {
        return;
    }
    let half = Size::new(size.width.div_ceil(2), size.height.div_ceil(2));
    let mut coarse = mean_of_quads(plane, size, half);
    fill_unknown(&mut coarse, half);
    for (i, value) in plane.iter_mut().enumerate().filter(|(_, v)| v.is_nan()) {
        *value = coarse[half.index(i % size.width / 2, i / size.width / 2)];
    }
}

/// Mean of the known values in every 2×2 block; NaN when there are none.
fn mean_of_quads(plane: &[f32], size: Size, half: Size) -> Vec<f32> {
    let mut sums = vec![(0.0_f32, 0.0_f32); half.pixels()];
    for (i, value) in plane.iter().enumerate().filter(|(_, v)| !v.is_nan()) {
        let (sum, count) = &mut sums[half.index(i % size.width / 2, i / size.width / 2)];
        *sum += value;
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| sum / count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;

    fn box_mean_twin(plane: &[f32], size: Size, radius: usize) -> Vec<f32> {
        let near = |a: usize, b: usize| a.abs_diff(b) <= radius;
        (0..size.pixels())
            .map(|i| {
                let (x, y) = (i % size.width, i / size.width);
                let window: Vec<f64> = (0..size.pixels())
                    .filter(|j| near(j % size.width, x) && near(j / size.width, y) && !plane[*j].is_nan())
                    .map(|j| f64::from(plane[j]))
                    .collect();
                (window.iter().sum::<f64>() / window.len() as f64) as f32
            })
            .collect()
    }

    #[test]
    fn window_sums_add_every_width() {
        let values: Vec<f32> = (0..40).map(|i| (i * i % 17) as f32).collect();
        for width in 1..20 {
            let mut sums = vec![0.0; values.len() + 1 - width];
            window_sums(&values, width, &mut [0.0; 40], &mut sums);
            for (i, sum) in sums.iter().enumerate() {
                assert_eq!(*sum, values[i..i + width].iter().sum::<f32>(), "width {width} at {i}");
            }
        }
    }

    #[test]
    fn box_mean_agrees_with_the_plain_sum() {
        let mut noise = TestNoise(1);
        for (width, height) in [(1, 1), (2, 7), (9, 5), (13, 1)] {
            let size = Size::new(width, height);
            let mut plane = noise.normals(size.pixels(), 1.0, 2.0);
            plane[size.pixels() / 2] = f32::NAN;
            for radius in [0, 1, 3] {
                let (fast, slow) = (box_mean(&plane, size, radius), box_mean_twin(&plane, size, radius));
                for (a, b) in fast.iter().zip(&slow) {
                    assert!((a - b).abs() < 1e-5 || (a.is_nan() && b.is_nan()), "{a} {b}");
                }
            }
        }
    }

    #[test]
    fn a_huge_value_leaves_no_trace_beside_its_window() {
        let mut plane = vec![1.0; 15];
        plane[3] = 1e20;
        assert_eq!(box_mean(&plane, Size::new(15, 1), 1)[5..], [1.0; 10]);
    }

    #[test]
    fn unknown_values_come_from_their_neighbours() {
        let size = Size::new(5, 3);
        let mut plane = vec![f32::NAN; 15];
        (plane[0], plane[14]) = (2.0, 8.0);
        fill_unknown(&mut plane, size);
        assert_eq!(plane[1], 2.0);
        assert_eq!(plane[2], 2.0, "the left half of the pyramid knows nothing else");
        assert!(plane.iter().all(|v| (2.0..=8.0).contains(v)));
        let mut nothing = vec![f32::NAN; 15];
        fill_unknown(&mut nothing, size);
        assert!(nothing.iter().all(|v| v.is_nan()));
    }
}
