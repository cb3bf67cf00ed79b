//! Promises of the method as a whole.

use stack::{Estimate, Feature, Noise, SampleCounts, Silent, Window};

use super::*;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(40, 28);

/// A stack of noiseless features: depth falls to the right, albedo is a checker, visibility a soft edge.
fn stack() -> FeatureStack {
    let feature = |role: FeatureRole, value: &dyn Fn(usize, usize) -> f32| {
        let plane: Vec<f32> = (0..SIZE.pixels()).map(|i| value(i % SIZE.width, i / SIZE.width)).collect();
        let mean = Image::from_channels(SIZE, vec![plane; role.channels().len()]);
        Feature { role, estimate: Estimate { mean, noise: Noise::Unknown } }
    };
    let checker = |x: usize, y: usize| if (x / 5 + y / 5).is_multiple_of(2) { 0.3 } else { 0.7 };
    FeatureStack {
        window: Window::whole(SIZE),
        film: SIZE,
        samples: SampleCounts::uniform(SIZE.pixels(), vec![4, 4]),
        components: Vec::new(),
        indirect: None,
        gathered: None,
        features: vec![
            feature(FeatureRole::Albedo, &checker),
            feature(FeatureRole::Visibility, &|_, y| ((y as f32 - 14.0) * 0.8).tanh() * 0.5 + 0.5),
            feature(FeatureRole::Depth, &|x, _| 10.0 - 0.1 * x as f32),
        ],
        passthrough: Vec::new(),
    }
}

/// Colours that are linear in column and albedo, with noise of deviation `sigma`.
fn colours(sigma: f32) -> [Image; 2] {
    let mut noise = TestNoise(4);
    let planes = [0.0, 1.0, 2.0].map(|c| {
        let clean: Vec<f32> = (0..SIZE.pixels())
            .map(|i| {
                let (x, y) = (i % SIZE.width, i / SIZE.width);
                1.0 + 0.02 * x as f32 + if (x / 5 + y / 5).is_multiple_of(2) { 0.0 } else { 0.2 * c }
            })
            .collect();
        let noisy = clean.iter().map(|v| v + sigma * noise.normal() as f32).collect();
        (clean, noisy)
    });
    let (clean, noisy): (Vec<Vec<f32>>, Vec<Vec<f32>>) = planes.into_iter().unzip();
    [clean, noisy].map(|planes| Image::from_channels(SIZE, planes))
}

fn run(radiance: &Image, sigma: f32, variant: Variant) -> Reconstruction {
    let variance = Image::from_channels(SIZE, vec![vec![sigma * sigma; SIZE.pixels()]; 3]);
    let mut settings = Settings::default();
    settings.regression.window.radius = 7;
    rebuild(&stack(), radiance, &variance, variant, &settings, &Silent).unwrap()
}

fn error(a: &Image, b: &Image) -> f32 {
    let pairs = a.channels().iter().flatten().zip(b.channels().iter().flatten());
    pairs.map(|(a, b)| (a - b).powi(2)).sum::<f32>() / (3 * SIZE.pixels()) as f32
}

#[test]
fn constants_and_functions_linear_in_the_features_are_exact() {
    let flat = Image::from_channels(SIZE, vec![vec![0.7; SIZE.pixels()]; 3]);
    for variant in [Variant::Plain, Variant::Pilot, Variant::Visibility] {
        assert!(error(&run(&flat, 0.1, variant).picture, &flat) < 1e-12);
        let [clean, _] = colours(0.0);
        // A wide confidence interval, so that the checker's other squares take part.
        assert!(error(&run(&clean, 0.3, variant).picture, &clean) < 1e-7, "{variant:?}");
    }
}

#[test]
fn noise_shrinks_and_the_error_map_says_how_far() {
    let [clean, noisy] = colours(0.1);
    for variant in [Variant::Plain, Variant::Visibility] {
        let found = run(&noisy, 0.1, variant);
        let left = error(&found.picture, &clean);
        assert!(left < 0.15 * 0.01, "{variant:?}: {left}");
        let expected = found.mse.iter().sum::<f32>() / SIZE.pixels() as f32;
        assert!((0.3..4.0).contains(&(expected / left)), "{variant:?}: {expected} for {left}");
        assert!(found.bandwidth.unwrap().iter().all(|h| (0.01..=1.0).contains(h)));
    }
}

#[test]
fn a_firefly_leaves_its_neighbours_alone() {
    let [_, mut noisy] = colours(0.05);
    let mut variance = Image::from_channels(SIZE, vec![vec![0.0025; SIZE.pixels()]; 3]);
    let before = rebuild(&stack(), &noisy, &variance, Variant::Plain, &Settings::default(), &Silent).unwrap();
    let at = SIZE.index(20, 14);
    for c in 0..3 {
        noisy.channels_mut()[c][at] = 1000.0;
        variance.channels_mut()[c][at] = 1e6;
    }
    let after = rebuild(&stack(), &noisy, &variance, Variant::Plain, &Settings::default(), &Silent).unwrap();
    for neighbour in [at - 2, at + 1, at - SIZE.width, at + 3 * SIZE.width] {
        let (a, b) = (before.picture.rgb(neighbour)[0], after.picture.rgb(neighbour)[0]);
        assert!((a - b).abs() < 0.02, "{a} became {b}");
    }
}

#[test]
fn visibility_shows_shadows_that_the_others_cannot_see() {
    let visibility = stack().features[1].estimate.mean.channels()[0].clone();
    let mut noise = TestNoise(8);
    let clean = Image::from_channels(SIZE, vec![visibility.clone(); 3]);
    let noisy = visibility.iter().map(|v| v + 0.1 * noise.normal() as f32);
    let noisy: Vec<f32> = noisy.collect();
    let noisy = Image::from_channels(SIZE, vec![noisy; 3]);
    let [plain, seen] = [Variant::Plain, Variant::Visibility].map(|v| error(&run(&noisy, 0.1, v).picture, &clean));
    assert!(seen < 0.8 * plain, "{seen} against {plain}");
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let [_, noisy] = colours(0.1);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&noisy, 0.1, Variant::Plain))
    };
    assert_eq!(with(1), with(3));
}
