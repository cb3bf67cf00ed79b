//! What lies next, from few paths.

use stack::{Estimate, FeatureRole, Image, Noise, Silent, Size};

use super::super::test_scene::features;
use super::*;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(40, 32);

fn counts() -> SampleCounts {
    SampleCounts::uniform(SIZE.pixels(), vec![16; 2])
}

/// Floor that is lit but under a table, whose edge no other feature shows, and darker towards a wall.
fn lit(pixel: usize) -> f32 {
    let (x, y) = (pixel % SIZE.width, pixel / SIZE.width);
    if x < 20 { 0.9 - 0.01 * y as f32 } else { 0.1 + 0.01 * y as f32 }
}

/// Means of sixteen paths each that are lit or not.
fn of_few_paths(role: FeatureRole, seed: u64) -> Feature {
    let mut noise = TestNoise(seed);
    let mut half = || {
        let plane = (0..SIZE.pixels()).map(|pixel| {
            let hits = (0..16).filter(|_| noise.uniform() < f64::from(lit(pixel))).count();
            hits as f32 / 16.0
        });
        Image::from_channels(SIZE, vec![plane.collect()])
    };
    Feature { role, estimate: Estimate::from_buckets(vec![half(), half()], &counts()) }
}

fn rows_and_columns() -> FeatureSet {
    let along = |side: fn(usize) -> usize| (0..SIZE.pixels()).map(|p| side(p) as f32 / SIZE.width as f32).collect();
    features(SIZE, vec![along(|p| p % SIZE.width), along(|p| p / SIZE.width)]).set
}

fn rebuilt(next: &[&Feature]) -> Option<Vec<Vec<f32>>> {
    let how = Rebuilding::next_surface(1.4);
    let next: Vec<Cow<Feature>> = next.iter().map(|feature| Cow::Borrowed(*feature)).collect();
    rebuilt_by_others(&next, &rows_and_columns(), &counts(), how, &BestSettings::default(), &Silent).unwrap()
}

#[test]
fn noise_goes_and_the_edge_stays() {
    let [near, lit_next] = [(FeatureRole::Proximity, 5), (FeatureRole::Lit, 6)].map(|(r, seed)| of_few_paths(r, seed));
    let planes = rebuilt(&[&near, &lit_next]).unwrap();
    assert_eq!(planes.len(), 2);
    for (plane, feature) in planes.iter().zip([&near, &lit_next]) {
        let noisy = &feature.estimate.mean.channels()[0];
        // Natural scale: a range of 1 about 0.
        let squares =
            |value: &dyn Fn(usize) -> f32| (0..SIZE.pixels()).map(|p| (value(p) - lit(p)).powi(2)).sum::<f32>();
        let [before, after] = [squares(&|p| noisy[p]), squares(&|p| plane[p] + 0.5)];
        assert!(after < 0.3 * before, "{after} of {before}");
        let edge = |x: usize| (8..24).map(|y| plane[SIZE.index(x, y)]).sum::<f32>() / 16.0;
        assert!(edge(17) - edge(22) > 0.35, "{} {}", edge(17), edge(22));
    }
}

#[test]
fn what_does_not_come_in_buckets_is_left_to_others() {
    let Feature { role, estimate } = of_few_paths(FeatureRole::Lit, 7);
    let known = Feature { role, estimate: Estimate { mean: estimate.mean, noise: Noise::Unknown } };
    assert_eq!(rebuilt(&[&known]), None);
}

#[test]
fn halves_are_compared_by_their_own_noise() {
    let half = |value: f32| Image::from_channels(SIZE, vec![vec![value; SIZE.pixels()]]);
    let estimate = Estimate::from_buckets(vec![half(0.2), half(0.4)], &counts());
    let feature = Feature { role: FeatureRole::Lit, estimate };
    let noisy = Noisy::of(&feature, &counts(), &BestSettings::default()).unwrap();
    // (A − B)²/4 is the variance of the mean.
    assert!(noisy.variances[0].iter().all(|v| (v - 2.0 * 0.01).abs() < 1e-5), "{}", noisy.variances[0][0]);
}
