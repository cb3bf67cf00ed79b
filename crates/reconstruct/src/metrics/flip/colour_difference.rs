//! How different two pictures' colours look once the eye has blurred them (section 4.1 of the paper).

use std::f64::consts::PI;

use rayon::prelude::*;
use stack::Size;

use super::PIXELS_PER_DEGREE;
use super::colour::{from_ycxcz, hyab, to_hunt_lab};
use super::convolution::{Kernel, along_columns, along_rows, kernel, scaled};

/// Contrast sensitivity per opponent channel: Gaussians a·√(π/b)·exp(−π² d²/b) of the angle d in degrees, as (a, b).
const SENSITIVITY: [&[(f64, f64)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];

/// The largest b, which is the widest Gaussian.
const WIDEST: f64 = 0.04;

/// Exponent that makes small differences count more.
const QC: f32 = 0.7;
/// Share PC of the largest difference is mapped to PT, and what is beyond to the rest.
const PC: f32 = 0.4;
const PT: f32 = 0.95;

/// A picture of planes Y, Cx, Cz as the eye sees it, in Hunt-adjusted L\*a\*b\* per pixel.
pub fn seen(planes: &[Vec<f32>; 3], size: Size) -> Vec<[f32; 3]> {
    let blurred: [Vec<f32>; 3] = std::array::from_fn(|channel| blur(&planes[channel], size, SENSITIVITY[channel]));
    let colour = |pixel: usize| {
        let rgb = from_ycxcz([blurred[0][pixel], blurred[1][pixel], blurred[2][pixel]]);
        to_hunt_lab(rgb.map(|value| value.clamp(0.0, 1.0)))
    };
    (0..size.pixels()).into_par_iter().map(colour).collect()
}

/// Convolution with the sum of Gaussians, each of which is separable.
fn blur(plane: &[f32], size: Size, gaussians: &[(f64, f64)]) -> Vec<f32> {
    let mut sum = vec![0.0; plane.len()];
    for kernel in separated(gaussians) {
        let part = along_columns(&along_rows(plane, size, &kernel), size, &kernel);
        sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
    }
    sum
}

/// One-dimensional kernels whose outer products with themselves add up to the filter, of sum 1.
fn separated(gaussians: &[(f64, f64)]) -> Vec<Kernel> {
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as usize;
    let one_dimensional = |&(a, b): &(f64, f64)| {
        let height = (a * (PI / b).sqrt()).sqrt();
        kernel(radius, |x| height * (-(PI * x / PIXELS_PER_DEGREE).powi(2) / b).exp())
    };
    let kernels: Vec<Vec<f64>> = gaussians.iter().map(one_dimensional).collect();
    let total: f64 = kernels.iter().map(|kernel| kernel.iter().sum::<f64>().powi(2)).sum();
    kernels.iter().map(|kernel| scaled(kernel, 1.0 / total.sqrt())).collect()
}

/// The largest difference there is, between green and blue, raised to [`QC`].
pub fn largest() -> f32 {
    hyab(to_hunt_lab([0.0, 1.0, 0.0]), to_hunt_lab([0.0, 0.0, 1.0])).powf(QC)
}

/// Difference of two colours from [`seen`], from 0 to 1; `largest` is [`largest()`].
pub fn difference(a: [f32; 3], b: [f32; 3], largest: f32) -> f32 {
    let (difference, knee) = (hyab(a, b).powf(QC), PC * largest);
    if difference < knee { PT * difference / knee } else { PT + (1.0 - PT) * (difference - knee) / (largest - knee) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_filters_leave_a_constant_as_it_is() {
        let size = Size::new(5, 4);
        for gaussians in SENSITIVITY {
            assert!(blur(&[0.7; 20], size, gaussians).iter().all(|v| (v - 0.7).abs() < 1e-5));
        }
    }

    /// The two-dimensional filter as the paper has it, summed directly.
    #[test]
    fn the_separated_filter_is_the_sum_of_gaussians() {
        let (size, centre) = (Size::new(31, 31), 15_i32);
        let mut impulse = vec![0.0; size.pixels()];
        impulse[size.index(15, 15)] = 1.0;
        let found = blur(&impulse, size, SENSITIVITY[2]);
        let weight = |i: usize| {
            let (x, y) = ((i % 31) as i32 - centre, (i / 31) as i32 - centre);
            let squared = f64::from(x * x + y * y) / PIXELS_PER_DEGREE.powi(2);
            let inside = x.abs() <= 10 && y.abs() <= 10;
            let gaussian = |&(a, b): &(f64, f64)| a * (PI / b).sqrt() * (-PI * PI * squared / b).exp();
            if inside { SENSITIVITY[2].iter().map(gaussian).sum::<f64>() } else { 0.0 }
        };
        let total: f64 = (0..size.pixels()).map(weight).sum();
        for (i, found) in found.iter().enumerate() {
            assert!((f64::from(*found) - weight(i) / total).abs() < 1e-6);
        }
    }

    #[test]
    fn differences_run_from_zero_to_one() {
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(to_hunt_lab);
        assert_eq!(difference(green, green, largest()), 0.0);
        assert!((difference(green, blue, largest()) - 1.0).abs() < 1e-6);
    }
}
