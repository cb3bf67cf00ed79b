//! How much neighbouring pixels differ beyond lines and edges.

use std::ops::Range;

use rayon::prelude::*;
use stack::{Image, Size};

/// Lines through a pixel: along rows, columns and both diagonals.
const DIRECTIONS: [[isize; 2]; 4] = [[1, 0], [0, 1], [1, 1], [1, -1]];

/// What the least of the four directions' means is of white noise's variance (measured on normal noise).
const LEAST_OF_WHITE: f32 = 0.613;

/// Added to the squared brightness that noise of light is relative to.
const DARK: f32 = 1e-4;

/// How rough an image is along the smoothest of the lines through each pixel.
#[derive(Clone, Debug)]
pub struct Roughness {
    /// The variance of white noise that is as rough; NaN where nothing is known.
    pub variance: Image,
    /// What differences were measured relative to, squared.
    pub scale: Image,
}

/// Variance of white noise in every channel of `image`, from second differences y₋ − 2y + y₊ along lines through each pixel,
/// their squares a sixth of which is the variance on average. Of the four directions the one of least mean over 3×3 pixels
/// counts, so that straight edges and thin lines do not.
pub fn roughness(image: &Image) -> Image {
    roughness_over(image, |_, _, _| 1.0).variance
}

/// The same for light, whose noise grows with its brightness: differences are relative to the mean (y₋ + 2y + y₊)/4, so that
/// a dark line beside a lamp does not get the lamp's noise.
pub fn roughness_of_light(image: &Image) -> Roughness {
    roughness_over(image, |before, own, after| (0.25 * (before + 2.0 * own + after)).powi(2) + DARK)
}

/// Rows that one task works on.
const ROWS: usize = 16;

fn roughness_over(image: &Image, scale: impl Fn(f32, f32, f32) -> f32 + Sync) -> Roughness {
    let (size, channels) = (image.size(), image.channels().len());
    let mut planes = vec![vec![0.0; size.pixels()]; 2 * channels];
    let mut rest: Vec<_> = planes.iter_mut().map(|plane| plane.chunks_mut((ROWS * size.width).max(1))).collect();
    let tasks: Vec<Vec<&mut [f32]>> =
        (0..size.height.div_ceil(ROWS)).map(|_| rest.iter_mut().filter_map(Iterator::next).collect()).collect();
    tasks.into_par_iter().enumerate().for_each(|(number, mut task)| {
        let (variance, scales) = task.split_at_mut(channels);
        let first = number * ROWS;
        let rows = first..(first + ROWS).min(size.height);
        let mut least = vec![f32::INFINITY; rows.len() * size.width];
        for direction in DIRECTIONS {
            let along: Vec<Along> =
                image.channels().iter().map(|plane| Along::new(plane, size, direction, rows.clone(), &scale)).collect();
            for (pixel, least) in least.iter_mut().enumerate() {
                let total: f32 = along.iter().map(|along| along.squares[pixel]).sum();
                // The first direction counts where none is known.
                if total < *least || direction == DIRECTIONS[0] {
                    *least = if total.is_nan() { f32::INFINITY } else { total };
                    for (c, along) in along.iter().enumerate() {
                        variance[c][pixel] = along.squares[pixel] * along.scales[pixel] / LEAST_OF_WHITE;
                        scales[c][pixel] = along.scales[pixel];
                    }
                }
            }
        }
    });
    let scale = planes.split_off(channels);
    Roughness { variance: Image::from_channels(size, planes), scale: Image::from_channels(size, scale) }
}

/// Differences along one direction in some rows of a plane.
struct Along {
    /// Their squares, means over 3×3 pixels; NaN where none is known.
    squares: Vec<f32>,
    /// What each was taken relative to.
    scales: Vec<f32>,
}

impl Along {
    fn new(
        plane: &[f32],
        size: Size,
        direction: [isize; 2],
        rows: Range<usize>,
        scale: &impl Fn(f32, f32, f32) -> f32,
    ) -> Self {
        let width = size.width;
        let around = rows.start.saturating_sub(1)..(rows.end + 1).min(size.height);
        let mut squares = vec![f32::NAN; around.len() * width];
        let mut scales = vec![0.0; around.len() * width];
        let mut across = vec![[0.0; 2]; around.len() * width];
        for (i, y) in around.clone().enumerate() {
            let row = i * width..(i + 1) * width;
            second_differences(plane, size, direction, y, scale, &mut squares[row.clone()], &mut scales[row.clone()]);
            known_sums(&squares[row.clone()], &mut across[row]);
        }
        let mut means = Vec::with_capacity(rows.len() * width);
        for y in rows.clone() {
            let three = y.saturating_sub(1).max(around.start) - around.start..(y + 2).min(around.end) - around.start;
            let first = means.len();
            means.resize(first + width, 0.0);
            for x in 0..width {
                let (mut sum, mut count) = (0.0, 0.0);
                for i in three.clone() {
                    sum += across[i * width + x][0];
                    count += across[i * width + x][1];
                }
                means[first + x] = if count > 0.0 { sum / count } else { f32::NAN };
            }
        }
        scales.drain(..(rows.start - around.start) * width);
        scales.truncate(rows.len() * width);
        Self { squares: means, scales }
    }
}

/// Sums of three values side by side that are known, and how many they are.
fn known_sums(values: &[f32], sums: &mut [[f32; 2]]) {
    for (x, sum) in sums.iter_mut().enumerate() {
        *sum = [0.0; 2];
        for value in &values[x.saturating_sub(1)..(x + 2).min(values.len())] {
            let known = if value.is_nan() { [0.0; 2] } else { [*value, 1.0] };
            *sum = [sum[0] + known[0], sum[1] + known[1]];
        }
    }
}

/// For row `y`, a sixth of the squared second difference along a direction over its `scale`, NaN where a neighbour is
/// missing or not finite; and that scale, the pixel's own where a neighbour is missing.
fn second_differences(
    plane: &[f32],
    size: Size,
    [dx, dy]: [isize; 2],
    y: usize,
    scale: &impl Fn(f32, f32, f32) -> f32,
    squares: &mut [f32],
    scales: &mut [f32],
) {
    let row = |y: usize| (y < size.height).then(|| &plane[y * size.width..][..size.width]);
    let own = &plane[y * size.width..][..size.width];
    scales.iter_mut().zip(own).for_each(|(to, own)| *to = scale(*own, *own, *own));
    let (before, after) = (y.checked_add_signed(-dy).and_then(row), y.checked_add_signed(dy).and_then(row));
    let (Some(before), Some(after)) = (before, after) else { return };
    let margin = dx.unsigned_abs();
    let inner = margin..size.width.saturating_sub(margin).max(margin);
    for x in inner {
        let (before, after) = (before[x.wrapping_add_signed(-dx)], after[x.wrapping_add_signed(dx)]);
        let scale = scale(before, own[x], after);
        let square = (before - 2.0 * own[x] + after).powi(2) / (6.0 * scale);
        squares[x] = if square.is_finite() { square } else { f32::NAN };
        scales[x] = scale;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;

    const SIZE: Size = Size::new(64, 64);

    fn mean(image: &Image) -> f32 {
        image.channels()[0].iter().sum::<f32>() / image.pixels() as f32
    }

    #[test]
    fn white_noise_has_its_variance() {
        let noisy = Image::from_channels(SIZE, vec![TestNoise(5).normals(SIZE.pixels(), 3.0, 0.2)]);
        assert!((mean(&roughness(&noisy)) / 0.04 - 1.0).abs() < 0.1);
    }

    #[test]
    fn edges_and_slopes_have_none() {
        let value = |i: usize| if (i % 64) < 30 { 0.1 * (i / 64) as f32 } else { 9.0 };
        let edge = Image::from_channels(SIZE, vec![(0..SIZE.pixels()).map(value).collect()]);
        let rough = roughness(&edge);
        let inner = (1..63).flat_map(|y| (1..63).map(move |x| SIZE.index(x, y)));
        assert!(inner.into_iter().all(|i| rough.channels()[0][i] < 1e-6));
    }

    #[test]
    fn a_dark_line_beside_a_lamp_has_little_noise() {
        let mut noise = TestNoise(6);
        let value = |i: usize| if i / 64 == 20 { 0.01 } else { 10.0 } * (1.0 + 0.1 * noise.normal() as f32);
        let lamp = Image::from_channels(SIZE, vec![(0..SIZE.pixels()).map(value).collect()]);
        let light = roughness_of_light(&lamp).variance;
        let on_line = |image: &Image| (5..59).map(|x| image.channels()[0][SIZE.index(x, 20)]).sum::<f32>() / 54.0;
        assert!(on_line(&light) < 1e-3 && on_line(&roughness(&lamp)) > 0.1);
        assert!((mean(&light) / 1.0 - 1.0).abs() < 0.2, "{}", mean(&light));
    }
}
