//! Which candidates are chosen, by the rule and by the network that comes along.

use stack::Size;

use super::super::split::Layers;
use super::super::test_scene::{error, flat, image, layers, two_halves};
use super::*;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(40, 30);

/// The mixtures by the rule and by the network.
fn run(candidates: &[[Image; 2]], layers: &Layers, clean: &Image) -> [[Image; 2]; 2] {
    let settings = ChoiceSettings::default();
    let features = two_halves(SIZE);
    let contest = Contest { candidates, low: &layers.low, pilot: clean, features: &features };
    let chooser = trained().unwrap();
    [None, Some(&chooser)].map(|chooser| mixtures(candidates, weights(&contest, &settings, chooser).channels()))
}

fn both(image: &Image) -> [Image; 2] {
    [image.clone(), image.clone()]
}

/// As many candidates as there are, all of them `other` but for the `k`-th.
fn one_of(k: usize, one: &[Image; 2], other: &[Image; 2]) -> Vec<[Image; 2]> {
    (0..CANDIDATES).map(|i| if i == k { one.clone() } else { other.clone() }).collect()
}

#[test]
fn the_right_candidate_wins_over_the_biased_ones() {
    let clean = flat(SIZE, 1.0);
    let (layers, biased) = (layers(&clean, 0.1, 130), flat(SIZE, 1.3));
    for right in 0..CANDIDATES {
        for half in run(&one_of(right, &both(&clean), &both(&biased)), &layers, &clean).iter().flatten() {
            assert!(error(half, &clean) < 0.03 * error(&biased, &clean), "{right}: {}", error(half, &clean));
        }
    }
}

#[test]
fn among_few_the_right_one_wins_by_the_rule() {
    let clean = flat(SIZE, 1.0);
    let (layers, features, biased) = (layers(&clean, 0.1, 137), two_halves(SIZE), both(&flat(SIZE, 1.3)));
    for right in 0..FEW {
        let candidates: Vec<[Image; 2]> =
            (0..FEW).map(|k| if k == right { both(&clean) } else { biased.clone() }).collect();
        let contest = Contest { candidates: &candidates, low: &layers.low, pilot: &clean, features: &features };
        let weights = weights(&contest, &ChoiceSettings::default(), None);
        let mixed = mixtures(&candidates, weights.channels());
        assert!(mixed.iter().all(|half| error(half, &clean) < 0.03 * error(&biased[0], &clean)), "{right}");
    }
}

#[test]
fn each_surface_gets_the_candidate_that_is_right_there() {
    let clean = flat(SIZE, 1.0);
    let wrong = |right: bool| both(&image(SIZE, |x, _, _| if (x >= 20) == right { 1.4 } else { 1.0 }));
    let layers = layers(&clean, 0.1, 131);
    let candidates = one_of(1, &wrong(false), &wrong(true));
    for chosen in run(&candidates, &layers, &clean) {
        for (i, x) in (0..SIZE.pixels()).map(|i| (i, i % 40)).filter(|(_, x)| !(17..23).contains(x)) {
            assert!((chosen[0].rgb(i)[0] - 1.0).abs() < 0.1, "{i} at {x}: {}", chosen[0].rgb(i)[0]);
        }
    }
}

#[test]
fn equal_candidates_are_left_as_they_are() {
    let clean = image(SIZE, |x, y, c| 0.1 * (1 + x + 2 * y + c) as f32);
    let layers = layers(&clean, 0.2, 132);
    for half in run(&one_of(0, &both(&clean), &both(&clean)), &layers, &clean).iter().flatten() {
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
    let mut candidate = || [0, 1].map(|_| noise.normals(SIZE.pixels(), 1.0, 1e-3));
    let candidates: Vec<[Image; 2]> =
        (0..CANDIDATES).map(|_| candidate().map(|plane| Image::from_channels(SIZE, vec![plane; 3]))).collect();
    for chosen in run(&candidates, &layers, &clean) {
        for (half, mixed) in chosen.iter().enumerate() {
            for i in 0..SIZE.pixels() {
                let own = candidates.iter().map(|candidate| candidate[half].rgb(i)[0]);
                let (low, high) = own.fold((f32::MAX, f32::MIN), |(low, high), v| (low.min(v), high.max(v)));
                assert!((low - 1e-6..=high + 1e-6).contains(&mixed.rgb(i)[0]), "{i}: {low} {high}");
            }
        }
    }
}

#[test]
fn mixtures_are_finite() {
    for clean in [flat(SIZE, 0.0), flat(SIZE, 1.0), flat(SIZE, 1e4)] {
        for other in [flat(SIZE, 0.5), clean.clone()] {
            let candidates = one_of(3, &both(&clean), &both(&other));
            for deviation in [0.0, 0.1] {
                let chosen = run(&candidates, &layers(&clean, deviation, 135), &clean);
                assert!(chosen.iter().flatten().flat_map(Image::channels).flatten().all(|v| v.is_finite()));
            }
        }
    }
}

#[test]
fn a_candidate_that_repeats_its_own_noise_does_not_win() {
    let clean = flat(SIZE, 1.0);
    let layers = layers(&clean, 0.2, 136);
    for chosen in run(&one_of(2, &both(&clean), &layers.low.halves), &layers, &clean) {
        for (half, noisy) in chosen.iter().zip(&layers.low.halves) {
            assert!(error(half, &clean) < 0.2 * error(noisy, &clean), "{}", error(half, &clean));
        }
    }
}

#[test]
fn evidence_comes_from_farther_around_where_noise_is_high() {
    let (clean, features, settings) = (flat(SIZE, 1.0), two_halves(SIZE), ChoiceSettings::default());
    let candidates = one_of(0, &both(&clean), &both(&flat(SIZE, 1.3)));
    for (deviation, is_noisy) in [(0.2, false), (2.0, true)] {
        let layers = layers(&clean, deviation, 138);
        let contest = Contest { candidates: &candidates, low: &layers.low, pilot: &clean, features: &features };
        let evidence = Evidence::new(&contest, &settings, Scales::All);
        let [finest, middle] = [0, 1].map(|level| &evidence.levels()[level]);
        let differ = |(a, b): (&f32, &f32)| (a - b).abs() > 1e-4 * middle.noise()[0];
        let different = finest.error(0).iter().zip(middle.error(0)).filter(|pair| differ(*pair)).count();
        assert_eq!(different == 0, is_noisy, "{different} of {} at {deviation}", SIZE.pixels());
    }
}
