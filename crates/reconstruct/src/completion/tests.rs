//! Stacks that lack things are completed, and rebuilt.

use stack::{Dealing, SampleCounts, Silent, Size};

use super::*;
use crate::best::test_scene::{energy, error, flat, image, stack_of, walls, with_noise};
use crate::test_noise::TestNoise;
use crate::{Method, Reconstruction, Settings, reconstruct};

const SIZE: Size = Size::new(48, 48);

fn completed(stack: &FeatureStack) -> Completed<'_> {
    complete(Cow::Borrowed(stack), &CompletionSettings::DEFAULT, &Silent).unwrap()
}

/// `stack` without anything known about noise, with the features that `keep` names.
fn poor(mut stack: FeatureStack, keep: &[FeatureRole]) -> FeatureStack {
    for component in &mut stack.components {
        component.radiance.noise = Noise::Unknown;
    }
    stack.features.retain(|feature| keep.contains(&feature.role));
    stack.features.iter_mut().for_each(|feature| feature.estimate.noise = Noise::Unknown);
    stack.samples =
        SampleCounts { first: 0, total: vec![1; stack.size().pixels()], dealing: Dealing::PerBucket(vec![1]) };
    stack
}

const BOTH: [FeatureRole; 2] = [FeatureRole::Albedo, FeatureRole::Normal];

fn run(stack: &FeatureStack) -> Reconstruction {
    let found = reconstruct(stack, &Settings::default(), &Silent).unwrap();
    let values = found.picture.channels().iter().flatten().chain(&found.mse);
    assert!(values.into_iter().all(|v| v.is_finite() && *v >= 0.0), "something is negative or not a number");
    found
}

#[test]
fn a_stack_that_lacks_nothing_stays() {
    let mut stack = stack_of(&walls(SIZE), 1);
    stack.features[1].estimate.noise = Noise::VarianceOfMean(flat(SIZE, 0.0));
    let position = place::position_on_screen(SIZE);
    let estimate = Estimate { mean: position, noise: Noise::VarianceOfMean(flat(SIZE, 0.0)) };
    stack.features.insert(0, Feature { role: FeatureRole::Position, estimate });
    let completed = completed(&stack);
    assert!(matches!(completed.stack, Cow::Borrowed(_)) && completed.lacks.is_empty());
}

#[test]
fn one_sample_a_pixel_says_nothing_about_noise() {
    let clean = walls(SIZE);
    let mut noise = TestNoise(12);
    let mut stack = stack_of(&clean, 12);
    let mut buckets = vec![flat(SIZE, 0.0); 8];
    buckets[0] = with_noise(&clean, 0.2, &mut noise);
    let numbered = |total: u32| SampleCounts {
        first: 0,
        total: vec![total; SIZE.pixels()],
        dealing: Dealing::Numbered { sequences: 8, buckets: 8 },
    };
    stack.samples = numbered(1);
    stack.components[0].radiance = Estimate::from_buckets(buckets, &stack.samples);
    assert!(completed(&stack).lacks.contains(&Lack::NOISE));
    let noisy = stack.components[0].radiance.mean.clone();
    let [before, after] = [&noisy, &run(&stack).picture].map(|picture| error(picture, &clean));
    assert!(after < 0.2 * before, "{after} of {before}");
    stack.samples = numbered(2);
    assert!(!completed(&stack).lacks.contains(&Lack::NOISE));
}

#[test]
fn every_lack_is_told() {
    let rich = stack_of(&walls(SIZE), 2);
    assert_eq!(completed(&rich).lacks, [Lack::PLACE]);
    assert_eq!(completed(&poor(rich.clone(), &BOTH)).lacks, [Lack::PLACE, Lack::NOISE]);
    let mut colour = poor(rich, &[]);
    assert_eq!(completed(&colour).lacks, [Lack::FEATURES, Lack::NOISE]);
    colour.components[0].radiance.noise = Noise::VarianceOfMean(flat(SIZE, 0.1));
    let depth = Image::from_channels(SIZE, vec![vec![2.0; SIZE.pixels()]]);
    colour
        .features
        .push(Feature { role: FeatureRole::Depth, estimate: Estimate { mean: depth, noise: Noise::Unknown } });
    let completed = completed(&colour);
    assert_eq!(completed.lacks, [Lack::ALBEDO, Lack::POSITION, Lack::HALVES]);
    assert!(completed.lacks[2].to_string().starts_with("no buckets"));
    assert_eq!(completed.stack.features[0].role, FeatureRole::Position);
}

#[test]
fn the_picture_is_a_feature_where_there_is_no_albedo_unless_it_is_left_out() {
    let colour = poor(stack_of(&walls(SIZE), 2), &[]);
    let roles = |stack: &FeatureStack, settings: &CompletionSettings| -> Vec<FeatureRole> {
        complete(Cow::Borrowed(stack), settings, &Silent)
            .unwrap()
            .stack
            .features
            .iter()
            .map(|feature| feature.role)
            .collect()
    };
    assert_eq!(roles(&colour, &CompletionSettings::DEFAULT), [FeatureRole::Position, FeatureRole::Albedo]);
    let normal = poor(stack_of(&walls(SIZE), 2), &[FeatureRole::Normal]);
    let with_normal = roles(&normal, &CompletionSettings::DEFAULT);
    assert_eq!(with_normal, [FeatureRole::Position, FeatureRole::Albedo, FeatureRole::Normal]);
    let without = CompletionSettings { picture_noise: 0.0, ..CompletionSettings::DEFAULT };
    assert_eq!(roles(&colour, &without), [FeatureRole::Position]);
    assert_eq!(complete(Cow::Borrowed(&colour), &without, &Silent).unwrap().lacks, [Lack::FEATURES, Lack::NOISE]);
}

#[test]
fn the_picture_stands_in_for_albedo_on_mirrors_only() {
    let mut stack = stack_of(&walls(SIZE), 2);
    let index = |role| stack.features.iter().position(|feature| feature.role == role).unwrap();
    let (albedo, normal) = (index(FeatureRole::Albedo), index(FeatureRole::Normal));
    let mirror = |pixel: usize| (10..20).contains(&(pixel % SIZE.width)) && pixel / SIZE.width < 16;
    for (feature, of_mirror) in [(albedo, 0.0), (normal, 1.0)] {
        for plane in stack.features[feature].estimate.mean.channels_mut() {
            plane.iter_mut().enumerate().filter(|(pixel, _)| mirror(*pixel)).for_each(|(_, v)| *v = of_mirror);
        }
    }
    let before = stack.features[albedo].estimate.mean.clone();
    let shown = completed(&stack);
    assert!(shown.lacks.contains(&Lack::MIRRORED));
    let after = &shown.stack.feature(FeatureRole::Albedo).unwrap().estimate;
    for pixel in 0..SIZE.pixels() {
        assert_eq!(after.mean.rgb(pixel) != before.rgb(pixel), mirror(pixel), "{pixel}");
    }
    assert!(matches!(after.noise, Noise::VarianceOfMean(_)));

    let left_out = CompletionSettings { mirrors: false, ..CompletionSettings::DEFAULT };
    let kept = |stack: &FeatureStack, settings| {
        let completed = complete(Cow::Borrowed(stack), settings, &Silent).unwrap();
        completed.stack.feature(FeatureRole::Albedo).unwrap().estimate.mean == before
    };
    assert!(kept(&stack, &left_out));
    let lit = Estimate { mean: Image::zeros(SIZE, 1), noise: Noise::Unknown };
    stack.features.push(Feature { role: FeatureRole::Lit, estimate: lit });
    assert!(kept(&stack, &CompletionSettings::DEFAULT), "features follow the light there");
}

/// Mean measured variance over the true one in both walls.
fn ratios(clean: &Image, deviation: f32, features: &[FeatureRole]) -> [f32; 2] {
    let mut stack = stack_of(clean, 3);
    stack.components[0].radiance.mean = with_noise(clean, deviation, &mut TestNoise(4));
    let stack = poor(stack, features);
    let completed = completed(&stack);
    let variance = completed.stack.components[0].radiance.variance_of_mean(&stack.samples).unwrap();
    [0, 1].map(|side| {
        let pixels = (0..SIZE.pixels()).filter(|i| 2 * (i % SIZE.width) / SIZE.width == side);
        let sum: f32 = pixels.map(|i| variance.mean_at(i)).sum();
        sum / (0.5 * SIZE.pixels() as f32 * deviation * deviation)
    })
}

#[test]
fn measured_noise_is_of_the_right_size() {
    for ratio in ratios(&walls(SIZE), 0.05, &BOTH).into_iter().chain(ratios(&walls(SIZE), 0.05, &[])) {
        assert!((0.4..1.6).contains(&ratio), "{ratio}");
    }
}

#[test]
fn edges_and_checkers_are_not_noise() {
    // The checker's own variance is 0.04, 1600 times that of the noise.
    for features in [&BOTH[..], &[]] {
        let ratios = ratios(&walls(SIZE), 0.005, features);
        assert!(ratios.iter().all(|ratio| *ratio < 80.0), "{ratios:?}");
    }
}

#[test]
fn features_of_unknown_noise_are_freed_of_it() {
    let stack = poor(stack_of(&walls(SIZE), 5), &BOTH);
    let noise = &completed(&stack).stack.features[1].estimate.noise;
    let Noise::VarianceOfMean(variance) = noise else { panic!("{noise:?}") };
    let inner = SIZE.index(12, 20);
    let around: f32 = (0..9).map(|i| variance.mean_at(inner + i % 3 + SIZE.width * (i / 3))).sum::<f32>() / 9.0;
    // Eight buckets of deviation 0.05.
    assert!((0.2..3.0).contains(&(around / (0.0025 / 8.0))), "{around}");
}

#[test]
fn noise_falls_at_every_level() {
    let clean = walls(SIZE);
    let rich = stack_of(&clean, 6);
    let noisy = error(&rich.components[0].radiance.mean, &clean);
    let mut with_variance = poor(rich.clone(), &BOTH);
    let variance = rich.components[0].radiance.variance_of_mean(&rich.samples).unwrap();
    with_variance.components[0].radiance.noise = Noise::VarianceOfMean(variance);
    let levels = [(with_variance, 10.0), (poor(rich.clone(), &BOTH), 10.0), (poor(rich, &[]), 4.0)];
    for (level, (stack, least)) in levels.iter().enumerate() {
        let found = run(stack);
        let gain = noisy / error(&found.picture, &clean);
        assert!(gain > *least, "level {level}: the error falls {gain} times");
        let ratio = energy(&found.picture) / energy(&stack.components[0].radiance.mean);
        assert!((ratio - 1.0).abs() < 0.03, "level {level}: the energy is {ratio} times what it was");
    }
}

#[test]
fn every_method_takes_colour_alone() {
    let clean = walls(Size::new(24, 20));
    let stack = poor(stack_of(&clean, 7), &[]);
    for method in [Method::Wlr, Method::Wlrp, Method::Nfor, Method::Apr, Method::Ld] {
        let mut settings = Settings::default();
        settings.method.method = method;
        let found = reconstruct(&stack, &settings, &Silent).unwrap();
        assert!(found.picture.channels().iter().flatten().all(|v| v.is_finite()), "{method:?}");
        assert_eq!(found.lacks, [Lack::FEATURES, Lack::NOISE]);
    }
}

#[test]
fn black_pictures_and_single_pixels_are_rebuilt() {
    let black = poor(stack_of(&flat(SIZE, 0.0), 8), &[]);
    assert_eq!(run(&black).picture, flat(SIZE, 0.0));
    for (width, height) in [(1, 1), (1, 13), (13, 1), (2, 2)] {
        let clean = image(Size::new(width, height), |_, _, c| 0.5 + c as f32);
        for keep in [&BOTH[..], &[]] {
            let stack = poor(stack_of(&clean, 9), keep);
            let ratio = energy(&run(&stack).picture) / energy(&stack.components[0].radiance.mean);
            assert!((0.7..1.4).contains(&ratio), "{width}x{height}: {ratio}");
        }
    }
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let stack = poor(stack_of(&walls(SIZE), 10), &[]);
    let with =
        |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| run(&stack));
    assert!(with(1) == with(3));
}
