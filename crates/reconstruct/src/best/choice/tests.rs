//! Which candidate is chosen.

use stack::Size;

use super::super::test_scene::{error, flat, image, layers, two_halves};
use super::*;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(40, 30);

fn run(candidates: &[[Image; 2]], layers: &Layers, clean: &Image) -> [Image; 2] {
    let settings = ChoiceSettings::default();
    let ChoiceSettings { feature_scale, brightness, .. } = settings;
    let kernel = GuidedKernel::surfaces_and_brightness(&two_halves(SIZE), clean, feature_scale, brightness);
    choose(candidates, layers, &kernel, &settings)
}

fn both(image: &Image) -> [Image; 2] {
    [image.clone(), image.clone()]
}

#[test]
fn the_right_candidate_wins_over_the_biased_one() {
    let clean = flat(SIZE, 1.0);
    let (layers, biased) = (layers(&clean, 0.1, 130), flat(SIZE, 1.3));
    for right in [0, 1] {
        let mut candidates = [both(&biased), both(&biased)];
        candidates[right] = both(&clean);
        for half in run(&candidates, &layers, &clean) {
            assert!(error(&half, &clean) < 0.01 * error(&biased, &clean), "{}", error(&half, &clean));
        }
    }
}

#[test]
fn each_surface_gets_the_candidate_that_is_right_there() {
    let clean = flat(SIZE, 1.0);
    let wrong = |right: bool| image(SIZE, |x, _, _| if (x >= 20) == right { 1.4 } else { 1.0 });
    let layers = layers(&clean, 0.1, 131);
    let chosen = run(&[both(&wrong(false)), both(&wrong(true))], &layers, &clean);
    for (i, x) in (0..SIZE.pixels()).map(|i| (i, i % 40)).filter(|(_, x)| !(17..23).contains(x)) {
        assert!((chosen[0].rgb(i)[0] - 1.0).abs() < 0.1, "{i} at {x}");
    }
}

#[test]
fn equal_candidates_are_left_as_they_are() {
    let clean = image(SIZE, |x, y, c| 0.1 * (1 + x + 2 * y + c) as f32);
    let layers = layers(&clean, 0.2, 132);
    for half in run(&[both(&clean), both(&clean), both(&clean)], &layers, &clean) {
        let pairs = half.channels().iter().flatten().zip(clean.channels().iter().flatten());
        pairs.for_each(|(a, b)| assert!((a - b).abs() < 1e-5 * b, "{a} {b}"));
    }
}

#[test]
fn weights_add_up_to_one() {
    let clean = flat(SIZE, 1.0);
    let layers = layers(&clean, 0.3, 133);
    let mut noise = TestNoise(134);
    // Close candidates: were the weights to add up to anything else, the mixture would lie outside them.
    let mut candidate =
        || [0, 1].map(|_| image(SIZE, |_, _, _| 1.0).pixels()).map(|count| noise.normals(count, 1.0, 1e-3));
    let candidates: Vec<[Image; 2]> =
        (0..4).map(|_| candidate().map(|plane| Image::from_channels(SIZE, vec![plane; 3]))).collect();
    let chosen = run(&candidates, &layers, &clean);
    for (half, mixed) in chosen.iter().enumerate() {
        for i in 0..SIZE.pixels() {
            let own = candidates.iter().map(|candidate| candidate[half].rgb(i)[0]);
            let (low, high) = own.fold((f32::MAX, f32::MIN), |(low, high), v| (low.min(v), high.max(v)));
            assert!((low - 1e-6..=high + 1e-6).contains(&mixed.rgb(i)[0]), "{i}: {low} {high}");
        }
    }
}

#[test]
fn mixtures_are_finite() {
    for clean in [flat(SIZE, 0.0), flat(SIZE, 1.0), flat(SIZE, 1e4)] {
        let chosen = run(&[both(&clean), both(&flat(SIZE, 0.5))], &layers(&clean, 0.1, 135), &clean);
        assert!(chosen.iter().flat_map(|h| h.channels()).flatten().all(|v| v.is_finite()));
    }
}

#[test]
fn a_candidate_that_repeats_its_own_noise_does_not_win() {
    let clean = flat(SIZE, 1.0);
    let layers = layers(&clean, 0.2, 136);
    let chosen = run(&[layers.halves.clone(), both(&clean)], &layers, &clean);
    for (half, noisy) in chosen.iter().zip(&layers.halves) {
        assert!(error(half, &clean) < 0.1 * error(noisy, &clean), "{}", error(half, &clean));
    }
}
