//! The picture itself as a feature, where no other tells textures.

use rayon::prelude::*;
use stack::Image;

use super::roughness::roughness;
use crate::block_matching::block_matched;
use crate::box_filter::box_mean;
use crate::exposure::median_brightness;
use crate::lone_light::share_like_neighbours;

/// Noise of one pixel is that of this many around it in each direction, on average.
const RADIUS: usize = 15;

/// Light is seen on a logarithmic scale above this share of the median.
const DARK: f32 = 0.1;

/// A difference of logarithms that is as much as one between black and white.
const RANGE: f32 = 8.0;

/// Least deviation of noise, on a scale of logarithms.
const LEAST_NOISE: f32 = 1e-3;

/// What becomes of red, green and blue: brightness, and two differences that it has no part in.
const OPPONENTS: [[f32; 3]; 3] = [[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], [0.5, 0.0, -0.5], [0.25, -0.5, 0.25]];

/// The way back.
const COLOURS: [[f32; 3]; 3] = [[1.0, 1.0, 2.0 / 3.0], [1.0, 0.0, -4.0 / 3.0], [1.0, -1.0, 2.0 / 3.0]];

/// The logarithm of `picture`, 0 in the dark, freed of `factor` times the noise that its roughness tells. Lone light is cut
/// first, and noise is made even by dividing by what it is around, because patches are compared as if it were. Pixels that are
/// not `wanted` may keep their noise. `None` where the picture is smaller than a patch.
pub fn without_noise(picture: &Image, wanted: &[bool], factor: f32) -> Option<Image> {
    let size = picture.size();
    let kept = share_like_neighbours(picture);
    let dark = DARK * median_brightness(picture).max(1e-6);
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
    let mut clean = block_matched(&even, wanted, size)?;
    for (plane, deviations) in clean.iter_mut().zip(&deviations) {
        plane.iter_mut().zip(deviations).for_each(|(value, deviation)| *value *= deviation);
    }
    let mut colours = mixed(&Image::from_channels(size, clean), COLOURS, |value, _| value);
    colours.channels_mut().iter_mut().flatten().for_each(|v| *v = (*v / RANGE).max(0.0));
    Some(colours)
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

#[cfg(test)]
mod tests {
    use stack::Size;

    use super::*;
    use crate::test_noise::TestNoise;

    const SIZE: Size = Size::new(48, 48);
    const ALL: [bool; SIZE.pixels()] = [true; SIZE.pixels()];

    /// Deviation of green from its mean over the right wall's inside, and the difference of both walls' means.
    fn walls(picture: &Image) -> [f32; 2] {
        let mean = |range: std::ops::Range<usize>, of: &dyn Fn(f32) -> f32| {
            let inside = |i: &usize| range.contains(&(i % SIZE.width));
            let values: Vec<f32> = (0..SIZE.pixels()).filter(inside).map(|i| of(picture.rgb(i)[1])).collect();
            values.iter().sum::<f32>() / values.len() as f32
        };
        let [left, right] = [mean(0..22, &|v| v), mean(26..48, &|v| v)];
        [mean(26..48, &|v| (v - right).powi(2)).sqrt(), right - left]
    }

    #[test]
    fn noise_goes_a_firefly_goes_and_the_edge_stays() {
        let mut noise = TestNoise(11);
        let mut plane = || -> Vec<f32> {
            let wall = |i: usize| if i % SIZE.width < 24 { 0.5 } else { 2.0 };
            (0..SIZE.pixels()).map(|i| wall(i) * (1.0 + 0.2 * noise.normal() as f32)).collect()
        };
        let mut picture = Image::from_channels(SIZE, vec![plane(), plane(), plane()]);
        picture.channels_mut().iter_mut().for_each(|plane| plane[SIZE.index(36, 20)] = 500.0);
        let [left, difference] = walls(&without_noise(&picture, &ALL, 1.2).unwrap());
        let [noisy, _] = walls(&without_noise(&picture, &ALL, 0.01).unwrap());
        assert!(left < 0.2 * noisy, "{left} of {noisy}");
        let expected = ((2.0 / 0.125_f32 + 1.0).ln() - (0.5 / 0.125_f32 + 1.0).ln()) / RANGE;
        assert!((difference / expected - 1.0).abs() < 0.1, "{difference} for {expected}");
    }

    #[test]
    fn black_pictures_are_black_and_small_ones_have_none() {
        let black = without_noise(&Image::zeros(SIZE, 3), &ALL, 1.2).unwrap();
        assert!(black.channels().iter().flatten().all(|v| *v == 0.0));
        assert!(without_noise(&Image::zeros(Size::new(7, 48), 3), &ALL[..7 * 48], 1.2).is_none());
    }

    #[test]
    fn opponents_lead_back_to_colours() {
        for (i, row) in COLOURS.iter().enumerate() {
            for j in 0..3 {
                let product: f32 = (0..3).map(|k| row[k] * OPPONENTS[k][j]).sum();
                assert!((product - if i == j { 1.0 } else { 0.0 }).abs() < 1e-6);
            }
        }
    }
}
