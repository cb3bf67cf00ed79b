//! Features on their natural scales.

use stack::{Estimate, Image, Noise, Silent, Size, Window};

use super::super::test_scene::{error, image, with_noise};
use super::*;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(30, 20);

fn stack_of(features: Vec<Feature>) -> FeatureStack {
    FeatureStack {
        window: Window::whole(SIZE),
        film: SIZE,
        samples: SampleCounts::uniform(SIZE.pixels(), vec![4; 8]),
        components: Vec::new(),
        indirect: None,
        gathered: None,
        features,
        passthrough: Vec::new(),
    }
}

fn known(role: FeatureRole, mut mean: Image) -> Feature {
    let channels = mean.channels_mut()[..role.channels().len()].to_vec();
    Feature { role, estimate: Estimate { mean: Image::from_channels(SIZE, channels), noise: Noise::Unknown } }
}

fn run(features: Vec<Feature>) -> Result<CleanFeatures, PrefilterError> {
    clean_features(&stack_of(features), &BestSettings::default(), &Silent)
}

fn range(plane: &[f32]) -> f32 {
    plane.iter().copied().fold(f32::MIN, f32::max) - plane.iter().copied().fold(f32::MAX, f32::min)
}

#[test]
fn every_role_has_its_natural_scale() {
    let ramp = |x: usize| x as f32 / 29.0;
    let found = run(vec![
        known(FeatureRole::Position, image(SIZE, |x, y, c| [400.0 * ramp(x), 10.0 * y as f32, 7.0][c])),
        known(FeatureRole::Albedo, image(SIZE, |x, _, _| 0.2 + 0.5 * ramp(x))),
        known(FeatureRole::Normal, image(SIZE, |x, _, _| 2.0 * ramp(x) - 1.0)),
        known(FeatureRole::Visibility, image(SIZE, |x, _, _| ramp(x))),
    ])
    .unwrap();
    let ranges: Vec<f32> = found.set.planes.iter().map(|plane| range(plane)).collect();
    let expected = [1.0, 190.0 / 400.0, 0.0, 0.5, 0.5, 0.5, 2.0, 2.0, 2.0, 1.0];
    assert!(ranges.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{ranges:?}");
    assert_eq!(found.set.groups, [0..3, 3..6, 6..9, 9..10]);
    assert_eq!(found.separating, (0..9).collect::<Vec<usize>>(), "visibility does not tell surfaces apart");
    assert!(found.separators().eq(found.set.planes[..9].iter().map(Vec::as_slice)));
}

#[test]
fn noise_goes_and_edges_stay() {
    let clean = image(SIZE, |x, y, c| if (x < 15) ^ (y < 10) { 0.2 } else { 0.6 + 0.1 * c as f32 });
    let mut noise = TestNoise(95);
    let stack = stack_of(Vec::new());
    let buckets = (0..8).map(|_| with_noise(&clean, 0.12, &mut noise)).collect();
    let estimate = Estimate::from_buckets(buckets, &stack.samples);
    let noisy = estimate.mean.clone();
    let found = run(vec![Feature { role: FeatureRole::Albedo, estimate }]).unwrap();
    let rebuilt =
        Image::from_channels(SIZE, found.set.planes.iter().map(|p| p.iter().map(|v| v + 0.5).collect()).collect());
    let [before, after] = [&noisy, &rebuilt].map(|image| error(image, &clean));
    assert!(after < 0.15 * before, "{after} of {before}");
}

#[test]
fn few_shadow_rays_leave_no_mottles() {
    let mut noise = TestNoise(96);
    let stack = stack_of(Vec::new());
    let flat = image(SIZE, |_, _, _| 0.6);
    let rays = |noise: &mut TestNoise| {
        let seen = (0..SIZE.pixels()).map(|_| (0..4).filter(|_| noise.uniform() < 0.6).count() as f32 / 4.0);
        Image::from_channels(SIZE, vec![seen.collect()])
    };
    let buckets = (0..8).map(|_| rays(&mut noise)).collect();
    let visibility =
        Feature { role: FeatureRole::Visibility, estimate: Estimate::from_buckets(buckets, &stack.samples) };
    let position = known(FeatureRole::Position, image(SIZE, |x, y, c| [x as f32, y as f32, 0.0][c]));
    let stack = stack_of(vec![position, visibility]);
    let [filtered, rebuilt] = [0.0, 1.2].map(|bandwidth| {
        let mut settings = BestSettings::default();
        settings.features.visibility_bandwidth = bandwidth;
        let found = clean_features(&stack, &settings, &Silent).unwrap();
        let plane = found.set.planes[3].iter().map(|v| v + 0.5).collect::<Vec<f32>>();
        error(&Image::from_channels(SIZE, vec![plane; 3]), &flat)
    });
    assert!(rebuilt < 0.75 * filtered, "{rebuilt} of {filtered}");
}

#[test]
fn without_features_there_is_an_error() {
    assert!(matches!(run(Vec::new()), Err(PrefilterError::NoFeatures)));
}
