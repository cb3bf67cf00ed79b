//! Relative mean squared error against two independent references.
//!
//! The noise of one reference adds to every error and hides the gap between good pictures. The product of the errors
//! against two references with independent noise does not contain it on average.

use stack::Image;

use super::average::{mean, trimmed_mean};
use super::judged::value;

/// Mean over pixels and channels of (x − r₁)(x − r₂)/(((r₁ + r₂)/2)² + ε). May be negative by chance. `None` without
/// pixels.
pub fn rmse_cross(image: &Image, references: [&Image; 2], pixels: &[usize], epsilon: f32) -> Option<f64> {
    mean(&pixel_errors(image, references, pixels, epsilon))
}

/// [`rmse_cross`] without the 0.1 % of pixels whose mean over channels is worst.
pub fn rmse_cross_trimmed(image: &Image, references: [&Image; 2], pixels: &[usize], epsilon: f32) -> Option<f64> {
    trimmed_mean(pixel_errors(image, references, pixels, epsilon))
}

/// Per pixel, the mean over channels.
fn pixel_errors(image: &Image, [first, second]: [&Image; 2], pixels: &[usize], epsilon: f32) -> Vec<f64> {
    let channels = image.channels();
    let error = |pixel: &usize| {
        let products = channels.iter().zip(first.channels()).zip(second.channels()).map(|((x, r1), r2)| {
            let (x, r1, r2) = (value(x, *pixel), value(r1, *pixel), value(r2, *pixel));
            let middle = 0.5 * (r1 + r2);
            (x - r1) * (x - r2) / (middle * middle + f64::from(epsilon))
        });
        products.sum::<f64>() / channels.len() as f64
    };
    pixels.iter().map(error).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::rmse::rmse;
    use crate::test_noise::TestNoise;
    use stack::Size;

    #[test]
    fn follows_the_formula() {
        let one = |v: f32| Image::from_channels(Size::new(1, 1), vec![vec![v]]);
        let error = rmse_cross(&one(2.0), [&one(1.0), &one(0.5)], &[0], 0.25).unwrap();
        assert!((error - 1.5 / (0.75 * 0.75 + 0.25)).abs() < 1e-12);
    }

    #[test]
    fn with_one_reference_twice_it_is_the_plain_error() {
        let mut noise = TestNoise(1);
        let size = Size::new(40, 40);
        let mut picture = || Image::from_channels(size, (0..3).map(|_| noise.normals(1600, 1.0, 0.3)).collect());
        let (image, reference) = (picture(), picture());
        let pixels: Vec<usize> = (0..1600).collect();
        let (cross, plain) = (
            rmse_cross(&image, [&reference; 2], &pixels, 0.001).unwrap(),
            rmse(&image, &reference, &pixels, 0.001).unwrap(),
        );
        assert!((cross / plain - 1.0).abs() < 1e-12);
    }

    #[test]
    fn noise_of_the_references_cancels() {
        let mut noise = TestNoise(1);
        let size = Size::new(100, 100);
        let mut noisy = || Image::from_channels(size, (0..3).map(|_| noise.normals(10_000, 1.0, 0.03)).collect());
        let references = [&noisy(), &noisy()];
        let image = Image::from_channels(size, vec![vec![1.05; 10_000]; 3]);
        let pixels: Vec<usize> = (0..10_000).collect();
        let truth = 0.05 * 0.05;
        assert!((rmse_cross(&image, references, &pixels, 0.001).unwrap() / truth - 1.0).abs() < 0.06);
        assert!(rmse(&image, references[0], &pixels, 0.001).unwrap() > 1.3 * truth);
    }
}
