//! How different two pictures' edges and points are (section 4.2 of the paper).

use rayon::prelude::*;
use stack::Size;

use super::PIXELS_PER_DEGREE;
use super::colour::grey;
use super::convolution::{Kernel, along_columns, along_rows, kernel, scaled};

/// Width of the detectors in degrees.
const WIDTH: f64 = 0.082;

/// Strength of the edge and of the point at each pixel.
pub struct Features {
    edges: Vec<f32>,
    points: Vec<f32>,
}

/// Detects edges and points in the plane Y of a picture, on a scale from 0 to 1.
pub fn features(luminance: &[f32], size: Size) -> Features {
    let [gaussian, first, second] = kernels();
    let plane: Vec<f32> = luminance.iter().map(|y| grey(*y)).collect();
    let [smooth, slope, curvature] = [&gaussian, &first, &second].map(|kernel| along_rows(&plane, size, kernel));
    Features {
        edges: lengths(&along_columns(&slope, size, &gaussian), &along_columns(&smooth, size, &first)),
        points: lengths(&along_columns(&curvature, size, &gaussian), &along_columns(&smooth, size, &second)),
    }
}

fn lengths(x: &[f32], y: &[f32]) -> Vec<f32> {
    x.par_iter().zip(y).map(|(x, y)| (x * x + y * y).sqrt()).collect()
}

/// A Gaussian of sum 1, and its first and second derivative, whose positive weights add up to 1 and negative ones to −1.
fn kernels() -> [Kernel; 3] {
    let sigma = 0.5 * WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * sigma).ceil() as usize;
    let gaussian = |x: f64| (-0.5 * (x / sigma).powi(2)).exp();
    let smooth = kernel(radius, gaussian);
    let normalised = scaled(&smooth, 1.0 / smooth.iter().sum::<f64>());
    let slope = kernel(radius, |x| -x * gaussian(x));
    let curvature = kernel(radius, |x| ((x / sigma).powi(2) - 1.0) * gaussian(x));
    [normalised, balanced(&slope), balanced(&curvature)]
}

fn balanced(kernel: &[f64]) -> Kernel {
    let above: f64 = kernel.iter().filter(|w| **w > 0.0).sum();
    let below: f64 = -kernel.iter().filter(|w| **w < 0.0).sum::<f64>();
    kernel.iter().map(|w| (w / if *w > 0.0 { above } else { below }) as f32).collect()
}

/// Difference of the features at a pixel, from 0 to 1; small ones count more.
pub fn difference(a: &Features, b: &Features, pixel: usize) -> f32 {
    let edges = (a.edges[pixel] - b.edges[pixel]).abs();
    let points = (a.points[pixel] - b.points[pixel]).abs();
    (edges.max(points) * std::f32::consts::FRAC_1_SQRT_2).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detectors_are_balanced_and_see_no_constant() {
        let [gaussian, first, second] = kernels();
        assert_eq!(gaussian.len(), 19);
        assert!((gaussian.iter().sum::<f32>() - 1.0).abs() < 1e-6);
        for kernel in [first, second] {
            let above: f32 = kernel.iter().filter(|w| **w > 0.0).sum();
            assert!((above - 1.0).abs() < 1e-6 && kernel.iter().sum::<f32>().abs() < 1e-6);
        }
        let flat = features(&[50.0; 30], Size::new(6, 5));
        assert!(flat.edges.iter().chain(&flat.points).all(|v| v.abs() < 1e-6));
    }

    #[test]
    fn a_step_from_black_to_white_is_an_edge_of_strength_one() {
        let size = Size::new(40, 20);
        let step: Vec<f32> = (0..800).map(|i| if i % 40 < 20 { -16.0 } else { 100.0 }).collect();
        let found = features(&step, size);
        let at = size.index(20, 10);
        assert!((found.edges[at] - 1.0).abs() < 1e-5 && (found.edges[at - 1] - 1.0).abs() < 1e-5);
        let flat = features(&[100.0; 800], size);
        assert!((difference(&found, &flat, at) - 0.5_f32.powf(0.25)).abs() < 1e-5);
    }
}
