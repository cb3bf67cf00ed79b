//! Peak signal-to-noise ratio.

use stack::Image;

use super::average::mean;
use super::srgb::encode;

/// 10·log₁₀(1/MSE) of the pictures as displayed: channels clamped to 0 … 1 and sRGB-encoded, peak 1; in decibel.
/// Infinite for equal pictures. `None` without pixels.
pub fn psnr(image: &Image, reference: &Image, pixels: &[usize]) -> Option<f64> {
    let channels = image.channels().iter().zip(reference.channels());
    let errors: Vec<f64> =
        channels.flat_map(|(x, r)| pixels.iter().map(|p| (encode(x[*p]) - encode(r[*p])).powi(2))).collect();
    mean(&errors).map(|mse| -10.0 * mse.log10())
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::Size;

    #[test]
    fn an_error_of_one_code_value_in_ten_is_twenty_decibel() {
        let image = Image::from_channels(Size::new(1, 1), vec![vec![1.5]]);
        // 0.787 412 encodes to 0.9.
        let reference = Image::from_channels(Size::new(1, 1), vec![vec![0.787_412_3]]);
        assert!((psnr(&image, &reference, &[0]).unwrap() - 20.0).abs() < 1e-4);
        assert_eq!(psnr(&image, &image, &[0]), Some(f64::INFINITY));
        assert_eq!(psnr(&image, &image, &[]), None);
    }
}
