//! Mean squared error.

use stack::Image;

use super::average::mean;
use super::judged::value;

/// Mean over pixels and channels of (x − r)², in squared radiance. `None` without pixels.
pub fn mse(image: &Image, reference: &Image, pixels: &[usize]) -> Option<f64> {
    let channel_means: Option<Vec<f64>> = image
        .channels()
        .iter()
        .zip(reference.channels())
        .map(|(x, r)| mean(&pixels.iter().map(|p| (value(x, *p) - value(r, *p)).powi(2)).collect::<Vec<_>>()))
        .collect();
    mean(&channel_means?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::Size;

    #[test]
    fn follows_the_formula() {
        let size = Size::new(2, 1);
        let image = Image::from_channels(size, vec![vec![1.0, 2.0], vec![0.0, f32::NAN]]);
        let reference = Image::from_channels(size, vec![vec![0.0, 5.0], vec![0.0, 2.0]]);
        assert_eq!(mse(&image, &reference, &[0, 1]), Some((1.0 + 9.0 + 4.0) / 4.0));
        assert_eq!(mse(&image, &reference, &[0]), Some(0.5));
        assert_eq!(mse(&image, &reference, &[]), None);
    }
}
