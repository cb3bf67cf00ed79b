//! What the cascade adds to a picture.

use stack::{Component, Silent, Size};

use super::super::edge_avoiding::EdgeAvoidingKernel;
use super::super::test_scene::{component, error, flat, image, two_halves, with_noise};
use super::*;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(48, 40);

fn counts() -> SampleCounts {
    SampleCounts::uniform(SIZE.pixels(), vec![4; 8])
}

/// `truth` in eight buckets with normal noise, whose mean has the given deviation.
fn noisy(truth: &Image, deviation: f32, seed: u64) -> Component {
    let mut noise = TestNoise(seed);
    component((0..8).map(|_| with_noise(truth, deviation * 8.0_f32.sqrt(), &mut noise)).collect(), &counts())
}

fn added(picture: &Image, component: &Component, settings: &CascadeSettings) -> Image {
    let parts = Parts::new(component.radiance.groups(&counts(), 8).unwrap(), &counts());
    added_parts(picture, parts, settings)
}

fn added_parts(picture: &Image, parts: Parts, settings: &CascadeSettings) -> Image {
    let features = two_halves(SIZE);
    let kernel = EdgeAvoidingKernel::on_surfaces(&features, settings.feature_scale);
    let mut added = picture.clone();
    let scrutiny = settings.scrutiny(parts.count());
    add_significant_residual(&mut added, parts, relative_to(picture), |step| kernel.taps(step), scrutiny, &Silent)
        .unwrap();
    added
}

#[test]
fn the_truth_hardly_changes() {
    let truth = image(SIZE, |x, y, _| if x < 24 { 0.5 } else { 1.0 + 0.01 * y as f32 });
    let component = noisy(&truth, 0.1, 120);
    let after = error(&added(&truth, &component, &CascadeSettings::default()), &truth);
    let of_noise = error(&component.radiance.mean, &truth);
    assert!(after < 0.1 * of_noise, "{after} of {of_noise}");
}

#[test]
fn a_missing_smooth_part_comes_back() {
    let bump = |x: usize, y: usize| 0.8 * (-((x as f32 - 12.0).powi(2) + (y as f32 - 20.0).powi(2)) / 72.0).exp();
    let truth = image(SIZE, |x, y, _| 0.5 + bump(x, y));
    let without = flat(SIZE, 0.5);
    let after = added(&without, &noisy(&truth, 0.05, 121), &CascadeSettings::default());
    let [missing, left] = [error(&without, &truth), error(&after, &truth)];
    assert!(left < 0.05 * missing, "{left} of {missing}");
}

#[test]
fn a_wrong_level_comes_right() {
    let after = added(&flat(SIZE, 2.0), &noisy(&flat(SIZE, 1.0), 0.1, 122), &CascadeSettings::default());
    let mean = after.channels().iter().flatten().sum::<f32>() / (3 * SIZE.pixels()) as f32;
    assert!((mean - 1.0).abs() < 0.02, "{mean}");
}

#[test]
fn all_of_the_residual_is_the_noisy_mean() {
    let truth = flat(SIZE, 1.0);
    let component = noisy(&truth, 0.1, 123);
    let without_scales = CascadeSettings { levels: 0, ..CascadeSettings::default() };
    let all_significant = CascadeSettings { significance_of_two: 0.0, ..CascadeSettings::default() };
    for (groups, settings) in [(8, without_scales), (2, all_significant)] {
        let parts = Parts::new(component.radiance.groups(&counts(), groups).unwrap(), &counts());
        let after = added_parts(&image(SIZE, |x, _, _| 0.02 * x as f32), parts, &settings);
        let pairs = after.channels().iter().flatten().zip(component.radiance.mean.channels().iter().flatten());
        pairs.for_each(|(a, b)| assert!((a - b).abs() < 1e-3, "{a} {b} with {settings:?}"));
    }
}

#[test]
fn fireflies_are_no_detail_even_where_two_meet_but_light_in_three_buckets_is() {
    let spot = SIZE.index(20, 20);
    // Details alone: no scale is left that counts in full.
    let settings = CascadeSettings { levels: 2, ..CascadeSettings::default() };
    let found = |bright: &[usize]| {
        let of_bucket =
            |b: usize| image(SIZE, |x, y, _| if (x, y) == (20, 20) && bright.contains(&b) { 40.0 } else { 1.0 });
        let parts = Parts::new((0..8).map(of_bucket).collect(), &counts());
        added_parts(&flat(SIZE, 1.0), parts, &settings).rgb(spot)[0] - 1.0
    };
    let [one, two, three, all] = [&[3][..], &[3, 6], &[0, 3, 6], &[0, 1, 2, 3, 4, 5, 6, 7]].map(found);
    assert!(one < 0.1 * 39.0 / 8.0 && two < 0.1 * 39.0 / 4.0, "{one} {two}");
    assert!(three > 0.1 * 39.0 * 3.0 / 8.0 && all > 0.8 * 39.0, "{three} {all}");
}

#[test]
fn nothing_becomes_negative() {
    let after = added(&flat(SIZE, 0.0), &noisy(&flat(SIZE, -0.2), 0.1, 124), &CascadeSettings::default());
    assert!(after.channels().iter().flatten().all(|v| *v >= 0.0));
}

#[test]
fn parts_that_add_up_are_their_sum() {
    let parts = Parts::adding_up([flat(SIZE, 0.25), flat(SIZE, 0.5)]);
    let features = two_halves(SIZE);
    let kernel = EdgeAvoidingKernel::on_surfaces(&features, 0.3);
    let mut sum = flat(SIZE, 0.0);
    add_significant_residual(
        &mut sum,
        parts,
        relative_to(&flat(SIZE, 1.0)),
        |step| kernel.taps(step),
        CascadeSettings::default().scrutiny(2),
        &Silent,
    )
    .unwrap();
    assert!(sum.channels().iter().flatten().all(|v| (v - 0.75).abs() < 1e-4));
}

#[test]
fn a_part_without_samples_is_not_taken_for_black() {
    let [bright, nothing] = [flat(SIZE, 2.0), flat(SIZE, 0.0)];
    let shares = [vec![1.0; SIZE.pixels()], vec![0.0; SIZE.pixels()]];
    let (found, _) = residuals(Parts::of(&[bright, nothing], shares.to_vec()), &flat(SIZE, 1.5));
    assert!(found.iter().flatten().all(|v| (v - 0.5).abs() < 1e-6));
}
