//! How much neighbouring pixels differ beyond lines and edges.

use rayon::prelude::*;
use stack::{Image, Size};

use crate::box_filter::box_mean;

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

fn roughness_over(image: &Image, scale: impl Fn(f32, f32, f32) -> f32 + Sync) -> Roughness {
    let size = image.size();
    let along: Vec<Vec<[Vec<f32>; 2]>> = DIRECTIONS
        .par_iter()
        .map(|direction| {
            let of_plane = |plane: &Vec<f32>| {
                let (squares, scales) = second_differences(plane, size, *direction, &scale);
                [box_mean(&squares, size, 1), scales]
            };
            image.channels().iter().map(of_plane).collect()
        })
        .collect();
    let total = |direction: &[[Vec<f32>; 2]], pixel: usize| {
        let sum: f32 = direction.iter().map(|[square, _]| square[pixel]).sum();
        if sum.is_nan() { f32::INFINITY } else { sum }
    };
    let smoothest: Vec<usize> = (0..size.pixels())
        .map(|pixel| {
            let totals: [f32; 4] = std::array::from_fn(|d| total(&along[d], pixel));
            (1..4).fold(0, |least, d| if totals[d] < totals[least] { d } else { least })
        })
        .collect();
    let image_of = |value: &dyn Fn(&[Vec<f32>; 2], usize) -> f32| {
        let plane = |c: usize| smoothest.iter().enumerate().map(|(pixel, d)| value(&along[*d][c], pixel)).collect();
        Image::from_channels(size, (0..image.channels().len()).map(plane).collect())
    };
    Roughness {
        variance: image_of(&|[squares, scales], pixel| squares[pixel] * scales[pixel] / LEAST_OF_WHITE),
        scale: image_of(&|[_, scales], pixel| scales[pixel]),
    }
}

/// A sixth of the squared second difference along `direction` over its `scale`, NaN where a neighbour is missing or not
/// finite; and that scale, the pixel's own where a neighbour is missing.
fn second_differences(
    plane: &[f32],
    size: Size,
    [dx, dy]: [isize; 2],
    scale: impl Fn(f32, f32, f32) -> f32,
) -> (Vec<f32>, Vec<f32>) {
    let at = |x: usize, y: usize, sign: isize| {
        let (x, y) = (x.checked_add_signed(sign * dx)?, y.checked_add_signed(sign * dy)?);
        (x < size.width && y < size.height).then(|| plane[size.index(x, y)])
    };
    let of_pixel = |pixel: usize| {
        let (x, y, own) = (pixel % size.width, pixel / size.width, plane[pixel]);
        let (Some(before), Some(after)) = (at(x, y, -1), at(x, y, 1)) else { return (f32::NAN, scale(own, own, own)) };
        let scale = scale(before, own, after);
        let square = (before - 2.0 * own + after).powi(2) / (6.0 * scale);
        (if square.is_finite() { square } else { f32::NAN }, scale)
    };
    (0..size.pixels()).map(of_pixel).unzip()
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
