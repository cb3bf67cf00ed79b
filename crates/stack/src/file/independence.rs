//! Renders that shall be independent must not hold the same noise.

use std::path::PathBuf;

use super::FileError;
use crate::Image;

/// A pixel is rough when it differs from the mean of its neighbours by more than this share of it.
const ROUGH: f32 = 1e-3;

/// Share of the rough pixels that must be equal to the last bit for two pictures to hold the same noise.
const SAME: f64 = 0.9;

/// Rough pixels after which pictures that mostly differ need not be looked at further.
const LOOKED_AT: u64 = 10_000;

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
