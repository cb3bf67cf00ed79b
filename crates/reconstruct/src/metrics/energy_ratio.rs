//! Whether light was lost or invented.

use stack::Image;

use super::judged::value;

/// Sum of the image over the sum of the reference, all channels together; 1 when no energy was lost. `None` when the
/// reference is black.
pub fn energy_ratio(image: &Image, reference: &Image, pixels: &[usize]) -> Option<f64> {
    let sum = |image: &Image| -> f64 {
        image.channels().iter().map(|channel| pixels.iter().map(|p| value(channel, *p)).sum::<f64>()).sum()
    };
    let whole = sum(reference);
    (whole != 0.0).then(|| sum(image) / whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::Size;

    #[test]
    fn is_the_ratio_of_sums() {
        let size = Size::new(3, 1);
        let image = Image::from_channels(size, vec![vec![1.0, 2.0, 50.0], vec![0.0, f32::NAN, 1.0]]);
        let reference = Image::from_channels(size, vec![vec![2.0, 2.0, 1.0], vec![0.0, 2.0, 1.0]]);
        assert_eq!(energy_ratio(&image, &reference, &[0, 1]), Some(0.5));
        assert_eq!(energy_ratio(&image, &Image::zeros(size, 2), &[0, 1]), None);
    }
}
