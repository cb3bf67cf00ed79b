//! Structural similarity.
//!
//! Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, *Image quality assessment: from error visibility to structural
//! similarity*, 2004: 11×11 Gaussian windows of σ = 1.5, K₁ = 0.01, K₂ = 0.03, windows that lie inside the image only.

use rayon::prelude::*;
use stack::{Image, Size};

use super::average::mean;
use super::srgb::luma;

const RADIUS: usize = 5;
const WINDOW: usize = 2 * RADIUS + 1;
const SIGMA: f64 = 1.5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Mean structural similarity of the lumas (Rec. 709, of the pictures clamped to 0 … 1 and sRGB-encoded) over the windows
/// centred on `pixels`; at most 1. `None` when no window fits, as in images smaller than 11×11.
///
/// # Panics
/// When an image has fewer than three channels.
pub fn ssim(image: &Image, reference: &Image, pixels: &[usize]) -> Option<f64> {
    let size = image.size();
    if size.width < WINDOW || size.height < WINDOW {
        return None;
    }
    let (x, y) = (luma(image), luma(reference));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<_>>();
    let planes = [product(&x, &x), product(&y, &y), product(&x, &y), x, y];
    let means: Vec<Vec<f64>> = planes.par_iter().map(|plane| window_means(plane, size)).collect();
    let inside = |pixel: &&usize| {
        let (column, row) = (*pixel % size.width, *pixel / size.width);
        (RADIUS..size.width - RADIUS).contains(&column) && (RADIUS..size.height - RADIUS).contains(&row)
    };
    let similarity = |pixel: &usize| {
        let [xx, yy, xy, x, y] = [0, 1, 2, 3, 4].map(|moment: usize| means[moment][*pixel]);
        (2.0 * x * y + C1) * (2.0 * (xy - x * y) + C2) / ((x * x + y * y + C1) * (xx - x * x + yy - y * y + C2))
    };
    mean(&pixels.iter().filter(inside).map(similarity).collect::<Vec<_>>())
}

/// Gaussian means of the windows around all pixels; wrong where the window reaches outside.
fn window_means(plane: &[f64], size: Size) -> Vec<f64> {
    let kernel = gaussian();
    let along = |values: &[f64], stride: usize| -> Vec<f64> {
        let reach = RADIUS * stride;
        let mut means = vec![0.0; values.len()];
        for i in reach..values.len().saturating_sub(reach) {
            means[i] = (0..WINDOW).map(|t| kernel[t] * values[i + t * stride - reach]).sum();
        }
        means
    };
    along(&along(plane, 1), size.width)
}

/// One-dimensional Gaussian weights that add up to 1.
fn gaussian() -> [f64; WINDOW] {
    let weights: [f64; WINDOW] = std::array::from_fn(|i| {
        let d = i as f64 - RADIUS as f64;
        (-d * d / (2.0 * SIGMA * SIGMA)).exp()
    });
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::srgb::encode;
    use crate::test_noise::TestNoise;

    fn grey(width: usize, height: usize, values: Vec<f32>) -> Image {
        Image::from_channels(Size::new(width, height), vec![values; 3])
    }

    #[test]
    fn equal_pictures_are_fully_similar_and_small_ones_have_no_window() {
        let mut noise = TestNoise(3);
        let image = grey(20, 15, noise.normals(300, 0.5, 0.2));
        let all: Vec<usize> = (0..300).collect();
        assert!((ssim(&image, &image, &all).unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(ssim(&image, &image, &[0, 19]), None, "corners are no centres");
        let small = grey(10, 30, vec![0.5; 300]);
        assert_eq!(ssim(&small, &small, &all), None);
    }

    #[test]
    fn constants_compare_by_luminance_alone() {
        let (a, b) = (encode(0.2), encode(0.5));
        let expected = (2.0 * a * b + C1) / (a * a + b * b + C1);
        let all: Vec<usize> = (0..144).collect();
        let found = ssim(&grey(12, 12, vec![0.2; 144]), &grey(12, 12, vec![0.5; 144]), &all).unwrap();
        assert!((found - expected).abs() < 1e-9);
    }
}
