//! A small noisy picture with every feature.

use stack::{
    Component, ComponentRole, Estimate, Feature, FeatureRole, FeatureStack, Image, SampleCounts, Silent, Size, Window,
};

use super::primary::Primary;
use crate::components::variance_of;
use crate::prefilter::PrefilterSettings;
use crate::test_noise::TestNoise;

pub(super) const SIZE: Size = Size::new(23, 17);

/// A lit plane with a checkered texture, half in shadow.
pub(super) fn truth(c: usize, i: usize) -> f32 {
    let light = if i % SIZE.width > 12 { 0.3 } else { 1.0 };
    light * albedo(c, i)
}

fn albedo(c: usize, i: usize) -> f32 {
    let (x, y) = (i % SIZE.width, i / SIZE.width);
    if (x / 5 + y / 5) % 2 == 0 { 0.7 } else { 0.2 + 0.1 * c as f32 }
}

/// Four buckets of `truth`, colours with relative noise of `sigma`, features almost without.
pub(super) fn noisy_stack(sigma: f32, seed: u64) -> FeatureStack {
    let samples = SampleCounts::uniform(SIZE.pixels(), vec![2; 4]);
    let mut noise = TestNoise(seed);
    let mut buckets = |channels: usize, sigma: f32, value: &dyn Fn(usize, usize) -> f32| {
        let mut channel = |c: usize| -> Vec<f32> {
            (0..SIZE.pixels()).map(|i| value(c, i) * (1.0 + sigma * noise.normal() as f32)).collect()
        };
        let mut bucket = || Image::from_channels(SIZE, (0..channels).map(&mut channel).collect());
        Estimate::from_buckets((0..4).map(|_| bucket()).collect(), &samples)
    };
    let radiance = buckets(3, sigma, &truth);
    let place = |c: usize, i: usize| [(i % SIZE.width) as f32, 0.0, (i / SIZE.width) as f32 * 2.0][c];
    let shade = |_: usize, i: usize| if i % SIZE.width > 12 { 0.1 } else { 1.0 };
    let mut noise = TestNoise(99);
    let mut feature = |role, channels: usize, value: &dyn Fn(usize, usize) -> f32| {
        let mut channel = |c: usize| -> Vec<f32> {
            (0..SIZE.pixels()).map(|i| value(c, i) * (1.0 + 0.01 * noise.normal() as f32)).collect()
        };
        let mut bucket = || Image::from_channels(SIZE, (0..channels).map(&mut channel).collect());
        Feature { role, estimate: Estimate::from_buckets((0..4).map(|_| bucket()).collect(), &samples) }
    };
    let features = vec![
        feature(FeatureRole::Position, 3, &place),
        feature(FeatureRole::Albedo, 3, &albedo),
        feature(FeatureRole::Normal, 3, &|c, _| if c == 1 { 1.0 } else { 0.0 }),
        feature(FeatureRole::Visibility, 1, &shade),
    ];
    let components = vec![Component { role: ComponentRole::Scattered, radiance }];
    let window = Window::whole(SIZE);
    FeatureStack {
        window,
        film: SIZE,
        samples,
        components,
        indirect: None,
        gathered: None,
        features,
        passthrough: Vec::new(),
    }
}

/// What the filter sees of the stack, `exposure` times as bright.
pub(super) fn primary_of(stack: &FeatureStack, exposure: f32) -> Primary {
    let mut radiance = stack.components[0].radiance.mean.clone();
    let mut variance = variance_of(&stack.components[0], &stack.samples).unwrap();
    radiance.channels_mut().iter_mut().flatten().for_each(|v| *v *= exposure);
    variance.channels_mut().iter_mut().flatten().for_each(|v| *v *= exposure * exposure);
    Primary::new(stack, &radiance, &variance, &PrefilterSettings::default(), &Silent).unwrap()
}

/// The noiseless picture.
pub(super) fn reference() -> Image {
    Image::from_channels(SIZE, (0..3).map(|c| (0..SIZE.pixels()).map(|i| truth(c, i)).collect()).collect())
}
