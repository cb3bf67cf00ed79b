//! Renders that shall be independent must not hold the same noise, nor show different things.

use std::path::PathBuf;

use super::FileError;
use crate::Image;

/// A pixel is rough when it differs from the mean of its neighbours by more than this share of it.
const ROUGH: f32 = 1e-3;

/// Share of the rough pixels that must be equal to the last bit for two pictures to hold the same noise.
const SAME: f64 = 0.9;

/// Rough pixels after which pictures that mostly differ need not be looked at further.
const LOOKED_AT: u64 = 10_000;

/// How much more two renders differ than neighbouring pixels of each do, squared, where they show different things. Noise makes
/// both differ alike, so that those of one picture hardly reach 1.
const UNLIKE: f64 = 4.0;

/// Squared difference relative to the squared values that anything may have.
const ALIKE: f64 = 1e-4;

/// Refuses two pictures with the very same noise. A picture without noise is equal in every render.
///
/// # Errors
/// When two are the same where they are noisy.
pub fn check_independent(paths: &[PathBuf], colours: &[&Image]) -> Result<(), FileError> {
    for (i, one) in colours.iter().enumerate() {
        let Some(j) = colours[..i].iter().position(|other| same_noise(one, other)) else { continue };
        return Err(FileError::SameNoise { first: paths[j].clone(), second: paths[i].clone() });
    }
    Ok(())
}

/// Whether two planes of one kind show different things. Light above 1 counts less the brighter it is.
pub fn is_unlike(a: &Image, b: &Image) -> bool {
    let width = a.size().width;
    let (mut apart, mut steps, mut all) = (0.0, 0.0, 0.0);
    let softened = |v: f32| if v > 1.0 { 2.0 - 1.0 / f64::from(v) } else { f64::from(v) };
    for (a, b) in a.channels().iter().zip(b.channels()) {
        for (a, b) in a.chunks(width).zip(b.chunks(width)) {
            let pairs = a.windows(2).zip(b.windows(2));
            for ([a, next_a], [b, next_b]) in pairs.map(|(a, b)| ([a[0], a[1]], [b[0], b[1]])) {
                let [a, next_a, b, next_b] = [a, next_a, b, next_b].map(softened);
                apart += (a - b).powi(2);
                steps += 0.5 * ((a - next_a).powi(2) + (b - next_b).powi(2));
                all += 0.5 * (a * a + b * b);
            }
        }
    }
    apart > UNLIKE * steps + ALIKE * all
}

fn same_noise(a: &Image, b: &Image) -> bool {
    let (mut rough, mut same) = (0_u64, 0_u64);
    for pixel in (0..a.pixels()).filter(|pixel| is_rough(a, *pixel)) {
        rough += 1;
        same += u64::from(a.rgb(pixel) == b.rgb(pixel));
        if rough == LOOKED_AT && 2 * same < rough {
            return false;
        }
    }
    rough > 0 && same as f64 >= SAME * rough as f64
}

/// Whether the green of a pixel differs from the mean of those to its left and right, or above and below.
fn is_rough(image: &Image, pixel: usize) -> bool {
    let (size, plane) = (image.size(), &image.channels()[1]);
    let (x, y) = (pixel % size.width, pixel / size.width);
    let apart = |a: usize, b: usize| {
        let mean = 0.5 * (plane[a] + plane[b]);
        (plane[pixel] - mean).abs() > ROUGH * mean.abs()
    };
    let across = x > 0 && x + 1 < size.width && apart(pixel - 1, pixel + 1);
    across || (y > 0 && y + 1 < size.height && apart(pixel - size.width, pixel + size.width))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Size;

    #[test]
    fn renders_of_different_things_are_unlike_and_noise_is_none() {
        let size = Size::new(32, 32);
        let noise = |i: usize, seed: usize| ((i * 7919 + seed * 104_729) % 1009) as f32 / 1009.0;
        let image = |f: &dyn Fn(usize) -> f32| Image::from_channels(size, vec![(0..1024).map(f).collect(); 3]);
        let ball = |i: usize| if (i % 32).abs_diff(10) + (i / 32).abs_diff(20) < 9 { 0.9 } else { 0.2 };
        let floor = |i: usize| if i / 32 > 16 { 0.8 } else { 0.3 };
        for strength in [0.0, 0.1, 1.0, 100.0] {
            let render = |of: &dyn Fn(usize) -> f32, seed| image(&|i| of(i) + strength * noise(i, seed));
            assert!(!is_unlike(&render(&ball, 1), &render(&ball, 2)), "{strength}");
            assert_eq!(is_unlike(&render(&ball, 1), &render(&floor, 2)), strength < 0.5, "{strength}");
        }
        assert!(!is_unlike(&image(&|_| 0.7), &image(&|_| 0.701)) && is_unlike(&image(&|_| 0.7), &image(&|_| 0.4)));
    }

    #[test]
    fn the_same_noise_is_refused_and_the_same_smooth_picture_is_not() {
        let size = Size::new(16, 16);
        let image = |f: &dyn Fn(usize) -> f32| Image::from_channels(size, vec![(0..256).map(f).collect(); 3]);
        let noise = image(&|i| (i * 7919 % 101) as f32);
        let mut one_pixel_off = noise.clone();
        one_pixel_off.channels_mut()[1][77] += 1.0;
        let ramp = image(&|i| (i % 16) as f32 + 1.0);
        let black = image(&|_| 0.0);
        assert!(same_noise(&noise, &noise) && same_noise(&noise, &one_pixel_off));
        assert!(!same_noise(&ramp, &ramp) && !same_noise(&black, &black));
        assert!(!same_noise(&noise, &image(&|i| (i * 7907 % 103) as f32)));
    }
}
