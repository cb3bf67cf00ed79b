//! The method as a whole.

use stack::{Dealing, Image, SampleCounts, Silent, Size};

use super::test_scene::{component, energy, error, flat, image, stack_of, walls};
use super::*;

const SIZE: Size = Size::new(48, 48);

fn run(stack: &FeatureStack) -> Reconstruction {
    let settings = BestSettings::default();
    let features = guide_features(stack, &settings.features, &Silent).unwrap();
    let found = rebuild(stack, Cow::Borrowed(&stack.components[0]), &features, &settings, &Silent).unwrap();
    let values = found.picture.channels().iter().flatten().chain(&found.mse);
    assert!(values.into_iter().all(|v| v.is_finite() && *v >= 0.0), "something is negative or not a number");
    found
}

/// How many times less the error is than the noise, and how many times the energy it is.
fn gains(clean: &Image, stack: &FeatureStack) -> (f32, f64) {
    let found = run(stack).picture;
    let noisy = &stack.components[0].radiance.mean;
    (error(noisy, clean) / error(&found, clean), energy(&found) / energy(noisy))
}

#[test]
fn noise_falls_tenfold_and_no_light_is_lost() {
    let clean = walls(SIZE);
    let (error, energy) = gains(&clean, &stack_of(&clean, 140));
    assert!(error > 10.0, "error falls {error} times");
    assert!((energy - 1.0).abs() < 0.01, "the energy is {energy} times what it was");
}

#[test]
fn exposure_hardly_matters() {
    for exposure in [0.2, 100.0] {
        let clean = image(SIZE, |x, y, c| exposure * walls(SIZE).rgb(SIZE.index(x, y))[c]);
        let (error, energy) = gains(&clean, &stack_of(&clean, 141));
        assert!(error > 8.0 && (energy - 1.0).abs() < 0.02, "{exposure}: {error} {energy}");
    }
}

#[test]
fn next_to_no_light_is_finite() {
    let clean = flat(SIZE, 1e-5);
    let (_, energy) = gains(&clean, &stack_of(&clean, 142));
    assert!((energy - 1.0).abs() < 0.05, "{energy}");
}

#[test]
fn fireflies_keep_their_energy_and_lose_their_height() {
    let clean = walls(SIZE);
    let mut stack = stack_of(&clean, 143);
    let mut buckets = match &stack.components[0].radiance.noise {
        stack::Noise::Buckets(buckets) => buckets.clone(),
        _ => unreachable!("there are buckets"),
    };
    for (b, [x, y]) in [[10, 10], [35, 20], [20, 40], [0, 47]].into_iter().enumerate() {
        buckets[b].channels_mut().iter_mut().for_each(|plane| plane[SIZE.index(x, y)] += 800.0);
    }
    stack.components = vec![component(buckets, &stack.samples)];
    let found = run(&stack);
    let noisy = &stack.components[0].radiance.mean;
    assert!((energy(&found.picture) / energy(noisy) - 1.0).abs() < 0.03, "{}", energy(&found.picture) / energy(noisy));
    assert!(found.picture.channels().iter().flatten().all(|v| *v < 8.0), "fireflies were 100 high");
    assert!(found.marked >= 4);
}

#[test]
fn black_stays_black() {
    let found = run(&stack_of(&flat(SIZE, 0.0), 144));
    assert_eq!(found.picture, flat(SIZE, 0.0));
    assert_eq!(found.marked, 0);
}

#[test]
fn equal_buckets_of_one_value_stay() {
    let mut stack = stack_of(&flat(SIZE, 1.0), 145);
    stack.components = vec![component(vec![flat(SIZE, 0.7); 8], &stack.samples)];
    assert!(run(&stack).picture.channels().iter().flatten().all(|v| (v - 0.7).abs() < 1e-4));
}

#[test]
fn pictures_of_a_pixel_or_a_line_are_rebuilt() {
    for (width, height) in [(1, 1), (1, 13), (13, 1), (2, 2)] {
        let clean = walls(Size::new(width, height));
        let stack = stack_of(&clean, 146);
        let found = run(&stack).picture;
        let ratio = energy(&found) / energy(&stack.components[0].radiance.mean);
        assert!((0.7..1.4).contains(&ratio), "{width}x{height}: {ratio}");
    }
}

#[test]
fn single_samples_are_enough_to_stay_finite() {
    let clean = walls(SIZE);
    let mut stack = stack_of(&clean, 147);
    for total in [vec![1; SIZE.pixels()], (0..SIZE.pixels()).map(|i| (i % 4) as u32).collect()] {
        stack.samples = SampleCounts { first: 0, total, dealing: Dealing::Numbered { sequences: 8, buckets: 8 } };
        let stack::Noise::Buckets(buckets) = stack.components[0].radiance.noise.clone() else { unreachable!() };
        stack.components = vec![component(buckets, &stack.samples)];
        let found = run(&stack).picture;
        assert!(error(&found, &clean) < error(&stack.components[0].radiance.mean, &clean));
    }
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let stack = stack_of(&walls(SIZE), 148);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&stack))
    };
    assert!(with(1) == with(4));
}

#[test]
fn means_and_relative_noise_follow_their_formulas() {
    let layers = test_scene::layers(&flat(SIZE, 2.0), 0.0, 149);
    let noise = relative_noise(&split::Layers { variance: flat(SIZE, 0.4), ..layers });
    assert!(noise.iter().all(|v| (v - 0.4 / 4.001).abs() < 1e-5));
    assert_eq!(mean_of(&[flat(SIZE, 1.0), flat(SIZE, 4.0)]), flat(SIZE, 2.5));
}
