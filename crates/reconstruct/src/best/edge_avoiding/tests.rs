//! The kernel against its formula.

use std::f32::consts::FRAC_1_SQRT_2;

use super::*;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(13, 9);

/// A kernel whose weights are exp(−Σ Δ²).
fn kernel(separators: &[Vec<f32>]) -> EdgeAvoidingKernel<'_> {
    EdgeAvoidingKernel::new(SIZE, separators.iter().map(Vec::as_slice).collect(), FRAC_1_SQRT_2)
}

/// Two planes, the second of which is an edge between columns 5 and 6.
fn separators(edge: f32) -> Vec<Vec<f32>> {
    let step = (0..SIZE.pixels()).map(|i| if i % SIZE.width < 6 { 0.0 } else { edge }).collect();
    vec![TestNoise(70).normals(SIZE.pixels(), 0.0, 0.4), step]
}

/// Σ h w v/Σ h w, h = the spline and w = exp(−Σ Δ²), in double precision.
fn twin(separators: &[Vec<f32>], plane: &[f32], step: isize, [x, y]: [usize; 2]) -> f64 {
    let binomial = [1.0, 4.0, 6.0, 4.0, 1.0];
    let (mut sum, mut total) = (0.0, 0.0);
    for (j, i) in (0..5).flat_map(|j| (0..5).map(move |i| (j, i))) {
        let (column, row) = (x as isize + (i - 2) * step, y as isize + (j - 2) * step);
        if (0..SIZE.width as isize).contains(&column) && (0..SIZE.height as isize).contains(&row) {
            let (p, q) = (SIZE.index(x, y), SIZE.index(column as usize, row as usize));
            let squares: f64 = separators.iter().map(|plane| f64::from(plane[p] - plane[q]).powi(2)).sum();
            let weight = binomial[i as usize] * binomial[j as usize] * (-squares).exp();
            sum += weight * f64::from(plane[q]);
            total += weight;
        }
    }
    sum / total
}

#[test]
fn agrees_with_the_formula() {
    let (separators, plane) = (separators(0.7), TestNoise(71).normals(SIZE.pixels(), 1.0, 1.0));
    let kernel = kernel(&separators);
    for step in [1, 2, 4, 8, 32] {
        let smooth = kernel.smooth(&[vec![0.0; SIZE.pixels()], plane.clone()], step);
        assert!(smooth[0].iter().all(|v| *v == 0.0));
        for (i, value) in smooth[1].iter().enumerate() {
            let expected = twin(&separators, &plane, step as isize, [i % SIZE.width, i / SIZE.width]);
            assert!((f64::from(*value) - expected).abs() < 1e-5, "{i}, step {step}: {value} {expected}");
        }
    }
}

#[test]
fn constants_stay() {
    for step in [1, 4, 100] {
        let smooth = kernel(&separators(2.0)).smooth(&[vec![0.3; SIZE.pixels()]], step);
        assert!(smooth[0].iter().all(|v| (v - 0.3).abs() < 1e-6));
    }
}

#[test]
fn nothing_crosses_an_edge() {
    let plane: Vec<f32> = (0..SIZE.pixels()).map(|i| if i % SIZE.width < 6 { 1.0 } else { 1000.0 }).collect();
    for step in [1, 2] {
        let smooth = kernel(&separators(6.0)).smooth(std::slice::from_ref(&plane), step);
        assert!(smooth[0].iter().zip(&plane).all(|(a, b)| (a - b).abs() < 1e-4 * b));
        let across = kernel(&separators(0.0)).smooth(std::slice::from_ref(&plane), step);
        assert!(across[0][5] > 100.0, "without the edge it does mix");
    }
}

/// The widest of taps 1, 2, 4 … `step` pixels apart without seams.
fn seamless(kernel: &EdgeAvoidingKernel, step: usize) -> Taps {
    let mut seamless = Seamless::new(|step| kernel.taps(step));
    let mut taps = seamless.taps(1);
    for level in 1..=step.ilog2() {
        taps = seamless.taps(1 << level);
    }
    taps
}

#[test]
fn no_seam_runs_where_taps_enter_the_picture() {
    let (size, step) = (Size::new(96, 96), 16);
    let kernel = EdgeAvoidingKernel::new(size, Vec::new(), 1.0);
    let plane: Vec<f32> = (0..size.pixels()).map(|i| (i % size.width) as f32).collect();
    // How far a ramp leaves a straight line from one pixel to the next, in its middle row.
    let largest_kink = |taps: Taps| {
        let smooth = taps.smooth(std::slice::from_ref(&plane)).remove(0);
        let row = &smooth[size.index(0, 48)..][..size.width];
        row.windows(3).map(|v| (v[0] - 2.0 * v[1] + v[2]).abs()).fold(0.0, f32::max)
    };
    let (with, without) = (largest_kink(seamless(&kernel, step)), largest_kink(kernel.taps(step)));
    assert!(without > 2.0 && with < 0.15 * without, "{with} {without}");
}

#[test]
fn what_is_narrow_is_smoothed_along_as_ever() {
    let (size, step) = (Size::new(200, 9), 4);
    let strip: Vec<f32> = (0..size.pixels()).map(|i| if i / size.width == 4 { 9.0 } else { 0.0 }).collect();
    let kernel = EdgeAvoidingKernel::new(size, vec![&strip], 1.0);
    let plane = TestNoise(72).normals(size.pixels(), 1.0, 1.0);
    let [with, without] = [seamless(&kernel, step), kernel.taps(step)].map(|taps| taps.smooth(&[&plane]).remove(0));
    for x in 50..150 {
        let pixel = size.index(x, 4);
        assert!((with[pixel] - without[pixel]).abs() < 1e-6);
    }
}
