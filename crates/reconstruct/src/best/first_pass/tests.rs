//! The first regression on pictures whose truth is known.

use std::borrow::Cow;

use stack::{Silent, Size};

use super::super::split::Layers;
use super::super::test_scene::{error, flat, layers, two_halves, walls};
use super::*;

const SIZE: Size = Size::new(40, 30);

fn settings() -> FitSettings {
    FitSettings { first_radius: 6, ..FitSettings::default() }
}

fn run(layers: &Layers, noise: f32) -> [Image; 2] {
    let (noise, features) = (vec![noise; SIZE.pixels()], Cow::Owned(two_halves(SIZE)));
    let given = Given { low: layers.low.clone(), noise, samples: None, features };
    first_pass(&layers.low.halves, &given, &settings(), &Silent).unwrap()
}

#[test]
fn constants_stay() {
    for half in run(&layers(&flat(SIZE, 0.4), 0.0, 100), 0.0) {
        assert!(half.channels().iter().flatten().all(|v| (v - 0.4).abs() < 1e-5));
    }
}

#[test]
fn both_halves_lose_most_of_their_noise_and_keep_the_edge() {
    let clean = super::super::test_scene::image(SIZE, |x, y, _| if x < 20 { 0.3 } else { 1.0 + 0.01 * y as f32 });
    let layers = layers(&clean, 0.15, 101);
    for (noisy, half) in layers.low.halves.iter().zip(&run(&layers, 0.05)) {
        assert!(
            error(half, &clean) < 0.1 * error(noisy, &clean),
            "{} of {}",
            error(half, &clean),
            error(noisy, &clean)
        );
    }
}

#[test]
fn weights_do_not_see_the_noise_that_they_weigh() {
    // Were a half its own guide, an outlier would resemble nothing else and stay as it is.
    let clean = flat(SIZE, 1.0);
    let mut layers = layers(&clean, 0.1, 103);
    let at = SIZE.index(10, 15);
    layers.low.halves[0].channels_mut().iter_mut().for_each(|plane| plane[at] = 3.0);
    let rebuilt = run(&layers, 0.01)[0].rgb(at)[0];
    assert!((rebuilt - 1.0).abs() < 0.3, "{rebuilt}");
}

#[test]
fn the_noise_of_one_half_stays_out_of_the_other() {
    let clean = walls(SIZE);
    let layers = layers(&clean, 0.15, 102);
    let rebuilt = run(&layers, 0.05);
    let residual = |image: &Image| -> Vec<f32> {
        image.channels().iter().flatten().zip(clean.channels().iter().flatten()).map(|(a, b)| a - b).collect()
    };
    let along = |a: &[f32], b: &[f32]| -> f32 {
        let products = a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>();
        products / b.iter().map(|b| b * b).sum::<f32>()
    };
    let [own, other] = [0, 1].map(|half: usize| along(&residual(&rebuilt[0]), &residual(&layers.low.halves[half])));
    assert!(own > 0.02 && other.abs() < 0.4 * own, "{own} of its own noise stays, {other} of the other's");
}
