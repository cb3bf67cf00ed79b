//! Small pictures for tests, whose truth is known.

use stack::{
    Component, ComponentRole, Estimate, Feature, FeatureRole, FeatureStack, Image, Noise, SampleCounts, Size, Window,
};

use super::features::CleanFeatures;
use super::split::{Events, Layers, LowLayer};
use crate::prefilter::FeatureSet;
use crate::test_noise::TestNoise;

/// An image whose channels are `value` of column, row and channel.
pub fn image(size: Size, value: impl Fn(usize, usize, usize) -> f32) -> Image {
    let plane = |c: usize| (0..size.pixels()).map(|i| value(i % size.width, i / size.width, c)).collect();
    Image::from_channels(size, (0..3).map(plane).collect())
}

/// An image of one value.
pub fn flat(size: Size, value: f32) -> Image {
    image(size, |_, _, _| value)
}

/// `image` with normal noise of the given deviation.
pub fn with_noise(image: &Image, deviation: f32, noise: &mut TestNoise) -> Image {
    let mut noisy = image.clone();
    noisy.channels_mut().iter_mut().flatten().for_each(|v| *v += deviation * noise.normal() as f32);
    noisy
}

/// Mean squared difference.
pub fn error(a: &Image, b: &Image) -> f32 {
    let pairs = a.channels().iter().flatten().zip(b.channels().iter().flatten());
    pairs.map(|(a, b)| (a - b).powi(2)).sum::<f32>() / (3 * a.pixels()) as f32
}

/// All light of an image.
pub fn energy(image: &Image) -> f64 {
    image.channels().iter().flatten().map(|v| f64::from(*v)).sum()
}

/// Features whose every plane tells surfaces apart.
pub fn features(size: Size, planes: Vec<Vec<f32>>) -> CleanFeatures {
    let separating = (0..planes.len()).collect();
    let set = FeatureSet { size, groups: std::iter::once(0..planes.len()).collect(), planes };
    CleanFeatures { set, separating, flat: false }
}

/// One feature: 0 in the left half, 1 in the right one.
pub fn two_halves(size: Size) -> CleanFeatures {
    features(
        size,
        vec![(0..size.pixels()).map(|i| if 2 * (i % size.width) < size.width { 0.0 } else { 1.0 }).collect()],
    )
}

/// Scattered light in `buckets`.
pub fn component(buckets: Vec<Image>, counts: &SampleCounts) -> Component {
    Component { role: ComponentRole::Scattered, radiance: Estimate::from_buckets(buckets, counts) }
}

/// Layers without events whose halves are `clean` with normal noise.
pub fn layers(clean: &Image, deviation: f32, seed: u64) -> Layers {
    let (size, mut noise) = (clean.size(), TestNoise(seed));
    let halves = [0, 1].map(|_| with_noise(clean, deviation, &mut noise));
    let variance = flat(size, deviation * deviation + 1e-7);
    let nothing = vec![0.0; size.pixels()];
    Layers {
        low: LowLayer { halves, variance },
        events: Events { light: [flat(size, 0.0), flat(size, 0.0)], energy: nothing.clone(), squares: nothing },
    }
}

/// Light on two walls that meet in the middle: a dark one, and a bright one with a checker, in a soft light.
pub fn walls(size: Size) -> Image {
    image(size, |x, y, c| {
        let light = 1.0 + 0.3 * (y as f32 * 0.08 + x as f32 * 0.03).sin();
        light * if 2 * x < size.width { 0.15 + 0.1 * c as f32 } else { checker(x, y) }
    })
}

fn checker(x: usize, y: usize) -> f32 {
    if (x / 12 + y / 12).is_multiple_of(2) { 0.9 } else { 0.5 }
}

/// A stack that shows `clean` in eight buckets of two samples, each of which is the truth times an exponentially
/// distributed number, with the features of [`walls`].
pub fn stack_of(clean: &Image, seed: u64) -> FeatureStack {
    let (size, mut noise) = (clean.size(), TestNoise(seed));
    let counts = SampleCounts::uniform(size.pixels(), vec![2; 8]);
    let mut bucket = || {
        let mut bucket = clean.clone();
        for i in 0..size.pixels() {
            let factor = (0..2).map(|_| -(1.0 - noise.uniform()).ln()).sum::<f64>() / 2.0;
            bucket.channels_mut().iter_mut().for_each(|plane| plane[i] *= factor as f32);
        }
        bucket
    };
    let components = vec![component((0..8).map(|_| bucket()).collect(), &counts)];
    FeatureStack {
        window: Window::whole(size),
        film: size,
        components,
        indirect: None,
        gathered: None,
        features: wall_features(size, &counts, &mut noise),
        samples: counts,
        passthrough: Vec::new(),
    }
}

/// Albedo with a little noise, and normals without any.
fn wall_features(size: Size, counts: &SampleCounts, noise: &mut TestNoise) -> Vec<Feature> {
    let left = |x: usize| 2 * x < size.width;
    let albedo = image(size, |x, y, _| if left(x) { 0.3 } else { checker(x, y) });
    let albedo = (0..8).map(|_| with_noise(&albedo, 0.05, noise)).collect();
    let normal = image(size, |x, _, c| if left(x) == (c == 0) && c != 1 { 1.0 } else { 0.0 });
    vec![
        Feature { role: FeatureRole::Albedo, estimate: Estimate::from_buckets(albedo, counts) },
        Feature { role: FeatureRole::Normal, estimate: Estimate { mean: normal, noise: Noise::Unknown } },
    ]
}
