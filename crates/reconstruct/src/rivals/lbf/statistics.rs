//! How planes vary around a pixel: spread, gradient, and distances from mean and median of a block. All of them are one
//! value per pixel for a group of planes (the channels of a colour or feature), in the planes' unit.

use stack::Size;

use crate::box_filter::box_mean;

/// Standard deviation within (2·`radius` + 1)² pixels, root mean square over the planes.
pub(super) fn spread(planes: &[Vec<f32>], size: Size, radius: usize) -> Vec<f32> {
    root_mean_square(planes, size, |plane| {
        let mean = box_mean(plane, size, radius);
        // Moments about the plane's first value: a wall far away would lose its detail to rounding.
        let first = plane.first().copied().unwrap_or_default();
        let squares: Vec<f32> = plane.iter().map(|v| (v - first) * (v - first)).collect();
        let squares = box_mean(&squares, size, radius);
        squares.iter().zip(&mean).map(|(square, mean)| (square - (mean - first) * (mean - first)).max(0.0)).collect()
    })
}

/// Distance from the mean of (2·`radius` + 1)² pixels, root mean square over the planes.
pub(super) fn distance_from_mean(planes: &[Vec<f32>], size: Size, radius: usize) -> Vec<f32> {
    root_mean_square(planes, size, |plane| {
        let mean = box_mean(plane, size, radius);
        plane.iter().zip(&mean).map(|(v, mean)| (v - mean) * (v - mean)).collect()
    })
}

/// Length of the gradient by central differences over two pixels, in units per pixel, root mean square over the planes.
/// At the border, differences are one-sided.
pub(super) fn gradient(planes: &[Vec<f32>], size: Size) -> Vec<f32> {
    root_mean_square(planes, size, |plane| {
        let slope = |low: usize, high: usize, steps: usize| (plane[high] - plane[low]) / steps.max(1) as f32;
        let at = |pixel: usize| {
            let (x, y) = (pixel % size.width, pixel / size.width);
            let (left, right) = (x.saturating_sub(1), (x + 1).min(size.width - 1));
            let (top, bottom) = (y.saturating_sub(1), (y + 1).min(size.height - 1));
            let across = slope(size.index(left, y), size.index(right, y), right - left);
            let down = slope(size.index(x, top), size.index(x, bottom), bottom - top);
            across * across + down * down
        };
        (0..size.pixels()).map(at).collect()
    })
}

/// Median absolute deviation from the median of 3×3 pixels, root mean square over the planes.
pub(super) fn median_deviation(planes: &[Vec<f32>], size: Size) -> Vec<f32> {
    let mut block = Vec::with_capacity(9);
    root_mean_square(planes, size, |plane| {
        let mut at = |pixel: usize| {
            block.clear();
            block.extend(crate::spikes::replace::block_around(pixel, size).map(|p| plane[p]));
            let median = median(&mut block);
            block.iter_mut().for_each(|v| *v = (*v - median).abs());
            self::median(&mut block).powi(2)
        };
        (0..size.pixels()).map(&mut at).collect()
    })
}

/// The middle of `values`, the lower one when there are two.
fn median(values: &mut [f32]) -> f32 {
    values.sort_unstable_by(f32::total_cmp);
    values[(values.len() - 1) / 2]
}

/// Squared step to the nearer neighbour in the row plus that in the column, summed over the planes: the square of how
/// far apart two pixels' values are on one surface, even beside its edge.
pub(super) fn squared_step(planes: &[Vec<f32>], size: Size) -> Vec<f32> {
    let squared = |a: usize, b: usize| planes.iter().map(|plane| (plane[a] - plane[b]).powi(2)).sum::<f32>();
    let least = |pixel: usize, before: bool, after: bool, step: usize| {
        let before = before.then(|| squared(pixel, pixel - step));
        let after = after.then(|| squared(pixel, pixel + step));
        before.into_iter().chain(after).reduce(f32::min).unwrap_or(0.0)
    };
    let at = |pixel: usize| {
        let (x, y) = (pixel % size.width, pixel / size.width);
        least(pixel, x > 0, x + 1 < size.width, 1) + least(pixel, y > 0, y + 1 < size.height, size.width)
    };
    (0..size.pixels()).map(at).collect()
}

/// Root of the mean of `square(plane)` over the planes; zeros when there are none.
fn root_mean_square(planes: &[Vec<f32>], size: Size, mut square: impl FnMut(&[f32]) -> Vec<f32>) -> Vec<f32> {
    let mut total = vec![0.0; size.pixels()];
    for plane in planes {
        total.iter_mut().zip(square(plane)).for_each(|(sum, v)| *sum += v);
    }
    let share = 1.0 / planes.len().max(1) as f32;
    total.iter_mut().for_each(|v| *v = (*v * share).sqrt());
    total
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size::new(5, 4);

    fn plane(value: impl Fn(f32, f32) -> f32) -> Vec<f32> {
        (0..SIZE.pixels()).map(|i| value((i % SIZE.width) as f32, (i / SIZE.width) as f32)).collect()
    }

    #[test]
    fn a_slope_has_its_gradient_everywhere_and_the_spread_of_its_steps() {
        let slope = [plane(|x, y| 1e3 + 3.0 * x + 4.0 * y)];
        assert!(gradient(&slope, SIZE).iter().all(|g| (g - 5.0).abs() < 1e-3));
        assert!(squared_step(&slope, SIZE).iter().all(|s| (s - 25.0).abs() < 1e-2));
        // 3×3 values of a ramp −1, 0, 1 have a variance of ⅔ along each axis.
        let inside = SIZE.index(2, 1);
        assert!((spread(&slope, SIZE, 1)[inside] - (25.0_f32 * 2.0 / 3.0).sqrt()).abs() < 1e-2);
        assert!(distance_from_mean(&slope, SIZE, 1)[inside] < 1e-3);
    }

    #[test]
    fn two_planes_count_by_half() {
        let planes = [plane(|x, _| x), plane(|_, _| 0.0)];
        assert!((gradient(&planes, SIZE)[7] - 0.5_f32.sqrt()).abs() < 1e-6);
        assert_eq!(gradient(&[], SIZE), vec![0.0; 20]);
    }

    #[test]
    fn a_spike_has_a_distance_but_no_median_deviation() {
        let mut spike = plane(|_, _| 1.0);
        spike[7] = 10.0;
        let planes = [spike];
        assert!((distance_from_mean(&planes, SIZE, 1)[7] - 8.0).abs() < 1e-5);
        assert_eq!(median_deviation(&planes, SIZE)[7], 0.0);
        // A block of nine consecutive numbers: distances 0 1 1 2 2 3 3 4 4 from their median.
        let counting = [plane(|x, y| x + 3.0 * y)];
        assert_eq!(median_deviation(&counting, SIZE)[SIZE.index(2, 1)], 2.0);
    }

    #[test]
    fn steps_do_not_cross_edges() {
        let edge = [plane(|x, _| if x < 2.0 { 0.0 } else { 100.0 })];
        assert_eq!(squared_step(&edge, SIZE), vec![0.0; 20]);
    }
}
