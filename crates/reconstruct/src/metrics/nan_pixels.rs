//! Pixels that are no numbers.

use stack::Image;

/// How many of `pixels` are NaN or infinite in any channel.
pub fn nan_pixels(image: &Image, pixels: &[usize]) -> u64 {
    pixels.iter().filter(|p| image.channels().iter().any(|channel| !channel[**p].is_finite())).count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::Size;

    #[test]
    fn a_pixel_counts_once() {
        let (nan, infinite) = (f32::NAN, f32::INFINITY);
        let image =
            Image::from_channels(Size::new(4, 1), vec![vec![nan, 0.0, infinite, nan], vec![nan, 1.0, 0.0, 0.0]]);
        assert_eq!(nan_pixels(&image, &[0, 1, 2]), 2);
    }
}
