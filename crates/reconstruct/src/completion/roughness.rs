//! How much neighbouring pixels differ beyond lines and edges.

use rayon::prelude::*;
use stack::{Image, Size};

use crate::box_filter::box_mean;

/// Lines through a pixel: along rows, columns and both diagonals.
const DIRECTIONS: [[isize; 2]; 4] = [[1, 0], [0, 1], [1, 1], [1, -1]];

/// What the least of the four directions' means is of white noise's variance (measured on normal noise).
const LEAST_OF_WHITE: f32 = 0.613;

/// Variance of white noise in every channel of `image`, from second differences y₋ − 2y + y₊ along lines through each pixel,
/// their squares a sixth of which is the variance on average. Of the four directions the one of least mean over 3×3 pixels
/// counts, so that straight edges and thin lines do not. NaN where nothing is known.
pub fn roughness(image: &Image) -> Image {
    let size = image.size();
    let along: Vec<Vec<Vec<f32>>> = DIRECTIONS
        .par_iter()
        .map(|direction| {
            let planes = image.channels().iter();
            planes.map(|plane| box_mean(&second_differences(plane, size, *direction), size, 1)).collect()
        })
        .collect();
    let total = |direction: &Vec<Vec<f32>>, pixel: usize| {
        let sum: f32 = direction.iter().map(|plane| plane[pixel]).sum();
        if sum.is_nan() { f32::INFINITY } else { sum }
    };
    let mut least = Image::from_channels(size, vec![vec![f32::NAN; size.pixels()]; image.channels().len()]);
    for pixel in 0..size.pixels() {
        let smoothest = along.iter().min_by(|a, b| total(a, pixel).total_cmp(&total(b, pixel)));
        for (c, plane) in least.channels_mut().iter_mut().enumerate() {
            plane[pixel] = smoothest.map_or(f32::NAN, |direction| direction[c][pixel]) / LEAST_OF_WHITE;
        }
    }
    least
}

/// A sixth of the squared second difference along `direction`; NaN where a neighbour is missing or not finite.
fn second_differences(plane: &[f32], size: Size, [dx, dy]: [isize; 2]) -> Vec<f32> {
    let at = |x: usize, y: usize, sign: isize| {
        let (x, y) = (x.checked_add_signed(sign * dx)?, y.checked_add_signed(sign * dy)?);
        (x < size.width && y < size.height).then(|| plane[size.index(x, y)])
    };
    let square = |pixel: usize| {
        let (x, y) = (pixel % size.width, pixel / size.width);
        let (Some(before), Some(after)) = (at(x, y, -1), at(x, y, 1)) else { return f32::NAN };
        let square = (before - 2.0 * plane[pixel] + after).powi(2) / 6.0;
        if square.is_finite() { square } else { f32::NAN }
    };
    (0..size.pixels()).map(square).collect()
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
}
