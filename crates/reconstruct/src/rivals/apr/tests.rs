//! Polynomials are what it finds, and of the order they have.

use stack::{Silent, Size};

use super::*;
use crate::regression::twin::Scene;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(45, 33);

/// A polynomial of `order` in position, with noise of deviation `sigma`; clean, then noisy.
fn polynomial(order: usize, sigma: f32) -> [Image; 2] {
    let mut noise = TestNoise(order as u64 + 1);
    let clean = |c: usize| -> Vec<f32> {
        let value = |i: usize| {
            let (u, v) = ((i % SIZE.width) as f32 / 15.0 - 1.5, (i / SIZE.width) as f32 / 15.0 - 1.0);
            let terms = [1.0, u - 0.7 * v, u * u + 0.8 * u * v - v * v, u * u * u - 1.1 * u * v * v + 0.9 * v * v * v];
            3.0 + 0.2 * c as f32 + terms[..=order].iter().sum::<f32>()
        };
        (0..SIZE.pixels()).map(value).collect()
    };
    let clean = Image::from_channels(SIZE, (0..3).map(clean).collect());
    let mut noisy = clean.clone();
    noisy.channels_mut().iter_mut().flatten().for_each(|v| *v += sigma * noise.normal() as f32);
    [clean, noisy]
}

fn constant(value: f32) -> Image {
    Image::from_channels(SIZE, vec![vec![value; SIZE.pixels()]; 3])
}

fn no_features() -> FeatureSet {
    FeatureSet { size: SIZE, planes: Vec::new(), groups: Vec::new() }
}

fn run(colour: &Image, sigma: f32, features: &FeatureSet, settings: AprSettings) -> PolynomialFit {
    fit_polynomials(colour, &constant(sigma * sigma), features, &settings, &Silent).unwrap()
}

fn error(a: &Image, b: &Image) -> f32 {
    let pairs = a.channels().iter().flatten().zip(b.channels().iter().flatten());
    pairs.map(|(a, b)| (a - b).powi(2)).sum::<f32>() / (3 * SIZE.pixels()) as f32
}

#[test]
fn polynomials_up_to_the_third_order_are_exact() {
    for order in 0..ORDERS {
        for stages in [1, 2] {
            let [clean, _] = polynomial(order, 0.0);
            let found = run(&clean, 0.0, &no_features(), AprSettings { stages, ..AprSettings::DEFAULT });
            assert!(error(&found.picture, &clean) < 1e-8, "order {order}");
        }
    }
}

#[test]
fn blocks_cover_every_pixel_however_far_apart_they_are_asked_for() {
    let settings = AprSettings { stride: 16, radius: 2, ..AprSettings::DEFAULT };
    let found = run(&constant(0.5), 0.1, &no_features(), settings);
    assert!(error(&found.picture, &constant(0.5)) < 1e-8);
}

#[test]
fn an_order_too_low_is_not_exact() {
    let [clean, _] = polynomial(3, 0.0);
    let found = run(&clean, 0.0, &no_features(), AprSettings { highest_order: 2, ..AprSettings::DEFAULT });
    assert!(error(&found.picture, &clean) > 1e-7);
}

#[test]
fn noisy_polynomials_are_given_their_own_order() {
    for (order, share) in [(0, 0.9), (1, 0.9), (2, 0.9), (3, 0.9)] {
        let [clean, noisy] = polynomial(order, 0.02);
        let found = run(&noisy, 0.02, &no_features(), AprSettings::DEFAULT);
        let all: usize = found.chosen.iter().sum();
        assert!(found.chosen[order] as f32 > share * all as f32, "order {order}: {:?}", found.chosen);
        assert!(error(&found.picture, &clean) < 0.1 * 4e-4);
    }
}

#[test]
fn colours_linear_in_the_features_are_exact() {
    let mut noise = TestNoise(5);
    let planes: Vec<Vec<f32>> = (0..3).map(|_| noise.normals(SIZE.pixels(), 0.0, 0.3)).collect();
    let linear = |c: usize| (0..SIZE.pixels()).map(move |i| (c, i));
    let value = |(c, i): (usize, usize)| 2.0 + planes[0][i] - 0.4 * c as f32 * planes[1][i] + 0.1 * planes[2][i];
    let colour = Image::from_channels(SIZE, (0..3).map(|c| linear(c).map(value).collect()).collect());
    let features = FeatureSet { size: SIZE, planes: planes.clone(), groups: vec![0..2, 2..3] };
    let found = run(&colour, 0.0, &features, AprSettings::DEFAULT);
    assert!(error(&found.picture, &colour) < 1e-8);
}

#[test]
fn a_picture_with_every_feature_gets_less_noisy() {
    let scene = Scene::new(Size::new(40, 33), 0.1);
    let found =
        fit_polynomials(&scene.colour, &scene.variance, &scene.features, &AprSettings::DEFAULT, &Silent).unwrap();
    let left: f32 = (0..3)
        .flat_map(|c| found.picture.channels()[c].iter().zip(&scene.clean.channels()[c]))
        .map(|(a, b)| (a - b).powi(2) / (3.0 * 1320.0))
        .sum();
    assert!(left < 0.2 * 0.01, "{left}");
}

#[test]
fn the_error_map_tells_the_error() {
    let [clean, noisy] = polynomial(1, 0.1);
    let found = run(&noisy, 0.1, &no_features(), AprSettings::DEFAULT);
    let expected = found.mse.iter().sum::<f32>() / SIZE.pixels() as f32;
    let ratio = expected / error(&found.picture, &clean);
    // Blocks average out part of one another's error, which their own estimates do not know of.
    assert!((0.8..5.0).contains(&ratio), "{ratio}");
}

#[test]
fn the_same_bytes_for_any_number_of_threads_and_pictures_smaller_than_a_block() {
    let [_, noisy] = polynomial(2, 0.1);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&noisy, 0.1, &no_features(), AprSettings::DEFAULT).picture)
    };
    assert_eq!(with(1), with(3));
    let size = Size::new(2, 1);
    let tiny = Image::from_channels(size, vec![vec![1.0, 2.0]; 3]);
    let features = FeatureSet { size, planes: Vec::new(), groups: Vec::new() };
    let found = fit_polynomials(&tiny, &tiny, &features, &AprSettings::DEFAULT, &Silent).unwrap();
    assert!(found.picture.channels().iter().flatten().all(|v| (0.9..2.1).contains(v)));
}
