//! The second regression on pictures whose truth is known.

use std::borrow::Cow;

use stack::{Silent, Size};

use super::super::split::Layers;
use super::super::test_scene::{error, flat, image, layers, two_halves, with_noise};
use super::*;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(40, 30);

fn run(layers: &Layers, pilot: &Image, settings: &FitSettings) -> Vec<[Image; 2]> {
    let (first, noise) = ([pilot.clone(), pilot.clone()], vec![0.05; SIZE.pixels()]);
    let given = Given { low: layers.low.clone(), noise, samples: None, features: Cow::Owned(two_halves(SIZE)) };
    second_pass(&layers.low.halves, &given, pilot, &first, settings, &Silent).unwrap()
}

fn settings() -> FitSettings {
    FitSettings { second_radius: 7, small_sigma: 1.0, ..FitSettings::default() }
}

#[test]
fn constants_stay_in_every_candidate() {
    let (clean, candidates) = (flat(SIZE, 0.4), 5);
    let found = run(&layers(&clean, 0.0, 110), &clean, &settings());
    assert_eq!(found.len(), candidates);
    let values = found.iter().flatten().flat_map(|half| half.channels().iter().flatten());
    assert!(values.into_iter().all(|v| (v - 0.4).abs() < 1e-5));
}

#[test]
fn few_candidates_are_among_all() {
    let clean = image(SIZE, |x, _, _| if x < 20 { 0.3 } else { 1.0 });
    let layers = layers(&clean, 0.15, 114);
    // A window too wide for the tiny one to be made by itself.
    let settings = FitSettings { tiny_sigma: 9.0, ..settings() };
    let [all, few] = [false, true].map(|few| run(&layers, &clean, &FitSettings { few, ..settings }));
    assert_eq!(few, [0, 1, 4].map(|k: usize| all[k].clone()));
}

#[test]
fn wider_kernels_and_windows_leave_less_noise() {
    let clean = image(SIZE, |x, _, _| if x < 20 { 0.3 } else { 1.0 });
    let layers = layers(&clean, 0.15, 111);
    let found = run(&layers, &with_noise(&clean, 0.02, &mut TestNoise(113)), &settings());
    let errors: Vec<f32> = found.iter().map(|[a, b]| error(a, &clean) + error(b, &clean)).collect();
    let noisy = error(&layers.low.halves[0], &clean) + error(&layers.low.halves[1], &clean);
    assert!(errors[..3].iter().all(|e| *e < 0.1 * noisy), "{errors:?} of {noisy}");
    assert!(errors[0] > errors[1] && errors[1] > errors[2] && errors[3] > 1.2 * errors[1], "{errors:?}");
}

#[test]
fn a_border_that_only_the_pilot_shows_stays() {
    let clean = image(SIZE, |_, y, _| if y < 15 { 0.2 } else { 2.0 });
    let found = run(&layers(&clean, 0.05, 112), &clean, &settings());
    // All but the widest kernel, which is for pictures without such borders.
    for [a, _] in [&found[0], &found[1], &found[3]] {
        for x in 0..40 {
            let [above, below] = [14, 15].map(|y| a.rgb(SIZE.index(x, y))[0]);
            assert!((above - 0.2).abs() < 0.1 && (below - 2.0).abs() < 0.1, "{above} {below}");
        }
    }
}

#[test]
fn tolerated_differences_follow_the_formula() {
    let first = [flat(SIZE, 1.0), flat(SIZE, 1.6)];
    let found = tolerated(&flat(SIZE, 2.0), &first, 0.01);
    let expected = 0.6_f32.powi(2) / 4.0 + 0.01 * 4.001;
    assert!(found.len() == 3 && found.iter().flatten().all(|v| (v - expected).abs() < 1e-5));
}
