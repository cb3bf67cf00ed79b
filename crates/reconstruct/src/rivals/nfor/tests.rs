//! Promises of the method as a whole.

use stack::{Estimate, Feature, FeatureRole, Silent, Window};

use super::*;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(36, 28);

/// Two halves, each value(pixel) with noise of deviation `sigma`.
fn halves(channels: usize, sigma: f32, seed: u64, value: impl Fn(usize, usize) -> f32) -> [Image; 2] {
    let mut noise = TestNoise(seed);
    [0, 1].map(|_| {
        let plane = |c: usize| (0..SIZE.pixels()).map(|i| (c, i)).collect::<Vec<_>>();
        let channel = |c: usize, noise: &mut TestNoise| {
            plane(c).into_iter().map(|(c, i)| value(c, i) + sigma * noise.normal() as f32).collect()
        };
        Image::from_channels(SIZE, (0..channels).map(|c| channel(c, &mut noise)).collect())
    })
}

/// A texture with a period of seven pixels, in its own contrast per channel.
fn albedo(c: usize, i: usize) -> f32 {
    let (x, y) = (i % SIZE.width, i / SIZE.width);
    0.5 + (0.1 + 0.1 * c as f32) * ((x as f32 * 0.9).sin() + (y as f32 * 0.9).cos())
}

/// Colours linear in column and albedo.
fn colour(c: usize, i: usize) -> f32 {
    1.0 + 0.03 * (i % SIZE.width) as f32 + 0.8 * albedo(c, i)
}

fn stack(sigma: f32, feature_sigma: f32) -> FeatureStack {
    let samples = SampleCounts::uniform(SIZE.pixels(), vec![8, 8]);
    let feature = Feature {
        role: FeatureRole::Albedo,
        estimate: Estimate::from_buckets(halves(3, feature_sigma, 2, albedo).into(), &samples),
    };
    let radiance = Estimate::from_buckets(halves(3, sigma, 1, colour).into(), &samples);
    FeatureStack {
        window: Window::whole(SIZE),
        film: SIZE,
        components: vec![Component { role: stack::ComponentRole::Scattered, radiance }],
        indirect: None,
        gathered: None,
        features: vec![feature],
        passthrough: Vec::new(),
        samples,
    }
}

fn run(stack: &FeatureStack) -> Reconstruction {
    rebuild(stack, &stack.components[0], true, &Settings::default(), &Silent).unwrap()
}

fn error(found: &Image, truth: impl Fn(usize, usize) -> f32) -> f32 {
    let squares = (0..3).flat_map(|c| (0..SIZE.pixels()).map(move |i| (c, i)));
    squares.map(|(c, i)| (found.channels()[c][i] - truth(c, i)).powi(2)).sum::<f32>() / (3 * SIZE.pixels()) as f32
}

#[test]
fn colours_linear_in_the_features_are_exact() {
    let found = run(&stack(0.0, 0.0));
    // Features without noise are still averaged where they differ by less than the least variance.
    assert!(error(&found.picture, colour) < 1e-6, "{}", error(&found.picture, colour));
}

#[test]
fn noise_shrinks_and_the_error_map_bounds_what_is_left() {
    let found = run(&stack(0.2, 0.01));
    let left = error(&found.picture, colour);
    assert!(left < 0.1 * 0.02, "{left}");
    let expected = found.mse.iter().sum::<f32>() / SIZE.pixels() as f32;
    assert!(expected > 0.5 * left && expected < 0.02, "{expected} for {left}");
    let sum = |value: &dyn Fn(usize) -> f32| (0..SIZE.pixels()).map(|i| f64::from(value(i))).sum::<f64>();
    let energy = sum(&|i| found.picture.rgb(i)[0]) / sum(&|i| colour(0, i));
    assert!((energy - 1.0).abs() < 0.01, "{energy}");
}

/// A dark pixel beside a thin bright edge of few samples would look like the edge to patches, if it was thought as noisy.
#[test]
fn a_pixel_takes_little_noise_from_a_noisier_line_beside_it() {
    let own = |i: usize| if i / SIZE.width == 14 { 25.0 } else { 1e-4 };
    let variance = Image::from_channels(SIZE, vec![(0..SIZE.pixels()).map(own).collect(); 3]);
    let found = variance_of_half(variance.clone(), MOST_AROUND);
    let at = |row: usize| found.channels()[1][SIZE.index(9, row)];
    assert!((at(13) / 5e-4 - 1.0).abs() < 0.01, "{}", at(13));
    assert!((at(14) / (25.0 + 25.0 / 3.0) - 1.0).abs() < 0.01, "half of its own, half of that around it: {}", at(14));
    let told_from_the_picture = variance_of_half(variance, f32::INFINITY);
    assert!(told_from_the_picture.channels()[1][SIZE.index(9, 13)] > 8.0);
    assert!((at(5) / 2e-4 - 1.0).abs() < 0.01, "{}", at(5));
}

#[test]
fn without_buckets_it_says_what_is_missing() {
    let mut stack = stack(0.1, 0.0);
    stack.components[0].radiance.noise = stack::Noise::Unknown;
    let error = rebuild(&stack, &stack.components[0], true, &Settings::default(), &Silent).unwrap_err();
    assert!(matches!(error, ReconstructError::NoBuckets { layer: "noisy" }));
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let stack = stack(0.2, 0.05);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&stack))
    };
    assert_eq!(with(1), with(2));
}
