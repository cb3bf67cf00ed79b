//! The picture itself as a feature, where there is no other.

use rayon::prelude::*;
use stack::Image;

use super::roughness::roughness;
use crate::block_matching::block_matched;
use crate::box_filter::box_mean;
use crate::lone_light::share_like_neighbours;

/// Noise of one pixel is that of this many around it in each direction, on average.
const RADIUS: usize = 10;

/// Light is seen on a logarithmic scale above this share of the median.
const DARK: f32 = 0.1;

/// A difference of logarithms that is as much as one between black and white.
const RANGE: f32 = 5.0;

/// Least deviation of noise, on a scale of logarithms.
const LEAST_NOISE: f32 = 1e-3;

/// What becomes of red, green and blue: brightness, and two differences that it has no part in.
const OPPONENTS: [[f32; 3]; 3] = [[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], [0.5, 0.0, -0.5], [0.25, -0.5, 0.25]];

/// The way back.
const COLOURS: [[f32; 3]; 3] = [[1.0, 1.0, 2.0 / 3.0], [1.0, 0.0, -4.0 / 3.0], [1.0, -1.0, 2.0 / 3.0]];

/// The logarithm of `picture`, 0 in the dark, freed of `factor` times the noise that its roughness tells. Lone light is cut
/// first, and noise is made even by dividing by what it is around, because patches are compared as if it were.
/// `None` where the picture is smaller than a patch.
pub fn without_noise(picture: &Image, factor: f32) -> Option<Image> {
    let size = picture.size();
    let kept = share_like_neighbours(picture);
    let dark = DARK * median(picture).max(1e-6);
    let opponents = mixed(picture, OPPONENTS, |value, pixel| ((value * kept[pixel]).max(0.0) / dark + 1.0).ln());
    let deviations: Vec<Vec<f32>> = roughness(&opponents)
        .channels()
        .par_iter()
        .map(|variance| {
            let around = box_mean(variance, size, RADIUS);
            around.iter().map(|v| factor * v.max(0.0).sqrt().max(LEAST_NOISE)).collect()
        })
        .collect();
    let even: Vec<Vec<f32>> = opponents.channels().iter().zip(&deviations).map(|(y, d)| ratio(y, d)).collect();
    let mut clean = block_matched(&even, size)?;
    for (plane, deviations) in clean.iter_mut().zip(&deviations) {
        plane.iter_mut().zip(deviations).for_each(|(value, deviation)| *value *= deviation);
    }
    let clean = Image::from_channels(size, clean);
    Some(mixed(&clean, COLOURS, |value, _| value)).map(|mut colours| {
        colours.channels_mut().iter_mut().flatten().for_each(|v| *v = (*v / RANGE).max(0.0));
        colours
    })
}

fn ratio(values: &[f32], by: &[f32]) -> Vec<f32> {
    values.iter().zip(by).map(|(value, by)| value / by).collect()
}

/// `matrix` times the three numbers that `scale` makes of every pixel.
fn mixed(image: &Image, matrix: [[f32; 3]; 3], scale: impl Fn(f32, usize) -> f32 + Sync) -> Image {
    let planes = crate::per_pixel::planes(image.pixels(), |pixel| {
        let values = image.rgb(pixel).map(|value| scale(value, pixel));
        matrix.map(|row| row.iter().zip(values).map(|(factor, value)| factor * value).sum())
    });
    Image::from_channels(image.size(), planes.into())
}

/// The median of brightness.
fn median(picture: &Image) -> f32 {
    let mut values: Vec<f32> = (0..picture.pixels()).map(|pixel| picture.mean_at(pixel)).collect();
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}
