//! Relative mean squared error, the paper's measure (section 7, after Rousselle et al. 2011).

use stack::Image;

use super::average::{mean, trimmed_mean};
use super::judged::value;

/// Mean over pixels and channels of (x − r)²/(r² + ε). The paper's ε is 0.001. `None` without pixels.
pub fn rmse(image: &Image, reference: &Image, pixels: &[usize], epsilon: f32) -> Option<f64> {
    mean(&pixel_errors(image, reference, pixels, epsilon))
}

/// [`rmse`] without the 0.1 % of pixels whose mean over channels is worst.
pub fn rmse_trimmed(image: &Image, reference: &Image, pixels: &[usize], epsilon: f32) -> Option<f64> {
    trimmed_mean(pixel_errors(image, reference, pixels, epsilon))
}

/// Per pixel, the mean over channels.
fn pixel_errors(image: &Image, reference: &Image, pixels: &[usize], epsilon: f32) -> Vec<f64> {
    let channels = reference.channels().len() as f64;
    let error = |pixel: &usize| {
        let pairs = image.channels().iter().zip(reference.channels());
        let squares = pairs.map(|(x, r)| {
            let (x, r) = (value(x, *pixel), value(r, *pixel));
            (x - r) * (x - r) / (r * r + f64::from(epsilon))
        });
        squares.sum::<f64>() / channels
    };
    pixels.iter().map(error).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::Size;

    #[test]
    fn follows_the_formula() {
        let size = Size::new(2, 1);
        let image = Image::from_channels(size, vec![vec![1.5, 0.5], vec![1.0, 0.0], vec![0.0, 0.0]]);
        let reference = Image::from_channels(size, vec![vec![1.0, 0.0], vec![1.0, 0.0], vec![3.0, 0.0]]);
        let expected = (0.25 / 1.5 + 9.0 / 9.5 + 0.25 / 0.5) / 6.0;
        assert!((rmse(&image, &reference, &[0, 1], 0.5).unwrap() - expected).abs() < 1e-12);
        let without_worst = (0.25 / 0.5) / 3.0;
        assert!((rmse_trimmed(&image, &reference, &[0, 1], 0.5).unwrap() - without_worst).abs() < 1e-12);
        assert_eq!(rmse(&image, &reference, &[], 0.5), None);
    }
}
