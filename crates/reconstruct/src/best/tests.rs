//! The method as a whole.

use std::borrow::Cow;

use stack::{Dealing, FeatureStack, Image, SampleCounts, Silent, Size};

use super::choice::trained;
use super::given::relative_noise;
use super::halves::mean_of;
use super::rebuild::rebuild;
use super::recipe::Recipe;
use super::settings::SpreadSettings;
use super::split::LowLayer;
use super::test_scene::{component, energy, error, flat, image, stack_of, walls};
use super::*;
use crate::reconstruction::Reconstruction;

const SIZE: Size = Size::new(48, 48);

fn run(stack: &FeatureStack) -> Reconstruction {
    with(stack, Extras::default())
}

fn with(stack: &FeatureStack, extras: Extras) -> Reconstruction {
    set(stack, &BestSettings::default(), extras)
}

fn set(stack: &FeatureStack, settings: &BestSettings, extras: Extras) -> Reconstruction {
    let features = clean_features(stack, settings, &Silent).unwrap();
    let (component, chooser) = (Cow::Borrowed(&stack.components[0]), trained().unwrap());
    let (chooser, features) = (Some(&chooser), &features);
    let counts = &stack.samples;
    let recipe = Recipe { counts, features, beside: None, settings, chooser, extras };
    let found = rebuild(&recipe, component, &Silent).unwrap();
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
fn a_thin_highlight_that_few_samples_met_with_is_no_haze() {
    let clean = walls(SIZE);
    let mut stack = stack_of(&clean, 150);
    let stack::Noise::Buckets(mut buckets) = stack.components[0].radiance.noise.clone() else { unreachable!() };
    // On the dark wall, in one bucket of each pixel.
    let highlight = |i: usize| SIZE.index(6 + i / 3, 8 + i);
    for i in 0..32 {
        buckets[3 * i % 8].channels_mut().iter_mut().for_each(|plane| plane[highlight(i)] += 8.0);
    }
    stack.components = vec![component(buckets, &stack.samples)];
    let above_the_wall = |lines: f32| {
        let spread = SpreadSettings { lines, ..SpreadSettings::default() };
        let settings = BestSettings { spread, ..BestSettings::default() };
        let found = set(&stack, &settings, Extras::default()).picture;
        (4..28).map(|i| found.rgb(highlight(i))[1] - clean.rgb(highlight(i))[1]).sum::<f32>() / 24.0
    };
    let [found, haze] = [2.0, 0.0].map(above_the_wall);
    assert!(found > 1.3 * haze, "{found} with lines, {haze} without, and 1 in truth");
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
    let low = test_scene::layers(&flat(SIZE, 2.0), 0.0, 149).low;
    let noise = relative_noise(&LowLayer { variance: flat(SIZE, 0.4), ..low });
    assert!(noise.iter().all(|v| (v - 0.4 / 4.001).abs() < 1e-5));
    assert_eq!(mean_of(&[flat(SIZE, 1.0), flat(SIZE, 4.0)]), flat(SIZE, 2.5));
}

#[test]
fn bands_of_rows_make_the_same_picture() {
    let stack = stack_of(&walls(Size::new(24, 160)), 145);
    assert_eq!(with(&stack, Extras { rows: 48, ..Extras::default() }), run(&stack));
}

#[test]
fn a_band_sees_all_that_the_second_pass_looks_at() {
    // Two windows, patches of 3×3, and 5×5 twice for what differences are tolerated.
    assert_eq!(second_pass::reach(&FitSettings { second_radius: 7, ..FitSettings::default() }), 14 + 1 + 4);
}

#[test]
fn passes_add_up_and_each_resembles_its_truth() {
    let clean = walls(SIZE);
    let stack = stack_of(&clean, 146);
    // Light that falls on one wall more than on the other.
    let share = |i: usize| if 2 * (i % SIZE.width) < SIZE.width { 0.7 } else { 0.2 };
    let part = |of: &Image, other: bool| {
        let mut part = of.clone();
        for plane in part.channels_mut() {
            plane.iter_mut().enumerate().for_each(|(i, v)| *v *= if other { 1.0 - share(i) } else { share(i) });
        }
        part
    };
    let noisy = &stack.components[0].radiance.mean;
    let passes = [part(noisy, false), part(noisy, true)];
    let found = with(&stack, Extras { passes: &passes, ..Extras::default() });
    assert_eq!(found.picture, run(&stack).picture);
    let [a, b] = &found.passes[..] else { panic!("two passes") };
    let (mut sum, truth) = (a.clone(), part(&clean, false));
    sum.add(b);
    assert!(error(&sum, &found.picture) < 1e-12, "{}", error(&sum, &found.picture));
    assert!(error(a, &truth) < 0.2 * error(&passes[0], &truth), "{} {}", error(a, &truth), error(&passes[0], &truth));
    let alone = with(&stack, Extras { passes: &passes[..1], ..Extras::default() });
    assert!(error(&alone.passes[0], a) < 1e-4, "what is not asked for counts as a pass");
}
