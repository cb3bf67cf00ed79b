//! Linear radiance as a display shows it.

use rayon::prelude::*;
use stack::Image;

/// The sRGB transfer function (IEC 61966-2-1) of a linear value, cut off to 0 … 1 first. What is not finite counts as black.
pub fn encode(linear: f32) -> f64 {
    let linear = if linear.is_finite() { f64::from(linear.clamp(0.0, 1.0)) } else { 0.0 };
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Luma of every pixel: 0.2126 R′ + 0.7152 G′ + 0.0722 B′ of the encoded channels (Rec. 709, whose primaries are sRGB's).
///
/// # Panics
/// When the image has fewer than three channels.
pub fn luma(image: &Image) -> Vec<f64> {
    let of = |pixel: usize| {
        let [r, g, b] = image.rgb(pixel).map(encode);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    (0..image.pixels()).into_par_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::Size;

    #[test]
    fn known_values_of_the_standard() {
        assert_eq!([0.0, -1.0, f32::NAN, f32::INFINITY].map(encode), [0.0; 4]);
        assert!((encode(1.0) - 1.0).abs() < 1e-12 && encode(7.0) == encode(1.0));
        // 8-bit 188 and 55 are the well-known codes of linear 0.5 and 0.0382.
        assert_eq!((encode(0.5) * 255.0).round(), 188.0);
        assert_eq!((encode(0.0382) * 255.0).round(), 55.0);
        assert!((encode(0.003_130_7) - encode(0.003_130_9)).abs() < 1e-5, "both branches meet");
    }

    #[test]
    fn luma_weighs_the_channels() {
        let image =
            Image::from_channels(Size::new(3, 1), vec![vec![1.0, 1.0, 0.0], vec![1.0, 0.0, 5.0], vec![1.0, 0.0, 0.0]]);
        let expected = [1.0, 0.2126, 0.7152];
        assert!(luma(&image).iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
