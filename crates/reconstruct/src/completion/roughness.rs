//! How much neighbouring pixels differ beyond lines and edges.

use rayon::prelude::*;
use stack::{Image, Size};

use crate::bands::{bands, image_rows};
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

/// Rows that one task works on: its planes, one per direction and channel, stay in the cache.
const ROWS: usize = 16;

/// A pixel's value depends on rows this far away: those of its window, and their neighbours.
const MARGIN: usize = 2;

fn roughness_over(image: &Image, scale: impl Fn(f32, f32, f32) -> f32 + Sync) -> Roughness {
    let (size, channels) = (image.size(), image.channels().len());
    let bands = bands(size.height, ROWS, MARGIN);
    let parts: Vec<Roughness> =
        bands.par_iter().map(|band| roughness_of_part(&image_rows(image, &band.around), &scale)).collect();
    let mut whole = Roughness { variance: Image::zeros(size, channels), scale: Image::zeros(size, channels) };
    for (band, part) in bands.iter().zip(parts) {
        band.put(&part.variance, &mut whole.variance);
        band.put(&part.scale, &mut whole.scale);
    }
    whole
}

fn roughness_of_part(part: &Image, scale: &impl Fn(f32, f32, f32) -> f32) -> Roughness {
    let (size, channels) = (part.size(), part.channels().len());
    // For each direction and channel the means of squares, and what differences are relative to.
    let along: [Vec<[Vec<f32>; 2]>; 4] = DIRECTIONS.map(|direction| {
        let of_plane = |plane: &Vec<f32>| {
            let [squares, scales] = second_differences(plane, size, direction, scale);
            [box_mean(&squares, size, 1), scales]
        };
        part.channels().iter().map(of_plane).collect()
    });
    let mut smoothest = vec![0; size.pixels()];
    for (pixel, smoothest) in smoothest.iter_mut().enumerate() {
        let mut least = f32::INFINITY;
        for (direction, along) in along.iter().enumerate() {
            let total: f32 = along.iter().map(|[squares, _]| squares[pixel]).sum();
            if total < least {
                (least, *smoothest) = (total, direction);
            }
        }
    }
    let image_of = |value: &dyn Fn(&[Vec<f32>; 2], usize) -> f32| {
        let plane = |c: usize| smoothest.iter().enumerate().map(|(pixel, d)| value(&along[*d][c], pixel)).collect();
        Image::from_channels(size, (0..channels).map(plane).collect())
    };
    Roughness {
        variance: image_of(&|[squares, scales], pixel| squares[pixel] * scales[pixel] / LEAST_OF_WHITE),
        scale: image_of(&|[_, scales], pixel| scales[pixel]),
    }
}

/// A sixth of the squared second difference along a direction over its `scale`, NaN where a neighbour is missing or not
/// finite; and that scale, the pixel's own where a neighbour is missing.
fn second_differences(
    plane: &[f32],
    size: Size,
    [dx, dy]: [isize; 2],
    scale: &impl Fn(f32, f32, f32) -> f32,
) -> [Vec<f32>; 2] {
    let mut squares = vec![f32::NAN; plane.len()];
    let mut scales: Vec<f32> = plane.iter().map(|own| scale(*own, *own, *own)).collect();
    let [across, down] = [dx, dy].map(isize::unsigned_abs);
    let step = dy * size.width as isize + dx;
    for y in down..size.height.saturating_sub(down) {
        for pixel in y * size.width + across..((y + 1) * size.width).saturating_sub(across) {
            let (before, after) = (plane[pixel.wrapping_add_signed(-step)], plane[pixel.wrapping_add_signed(step)]);
            let scale = scale(before, plane[pixel], after);
            let square = (before - 2.0 * plane[pixel] + after).powi(2) / (6.0 * scale);
            squares[pixel] = if square.is_finite() { square } else { f32::NAN };
            scales[pixel] = scale;
        }
    }
    [squares, scales]
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
    fn bands_have_no_seams() {
        let noisy = Image::from_channels(SIZE, vec![TestNoise(9).normals(SIZE.pixels(), 3.0, 0.2)]);
        let whole = roughness_of_part(&noisy, &|_, _, _| 1.0).variance;
        assert_eq!(roughness(&noisy), whole);
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
