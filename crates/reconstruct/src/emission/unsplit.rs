//! Finds directly seen lamps and backgrounds in a stack that has no emission layer.

use std::borrow::Cow;

use stack::{Component, ComponentRole, Estimate, Feature, FeatureRole, FeatureStack, Image, Monitor, Noise};

use crate::exposure::median_brightness;

/// A lamp is at least this many times as bright as the median pixel …
const BRIGHT: f32 = 5.0;

/// … and its buckets differ by no more than this share of their mean.
const STEADY: f32 = 0.02;

/// The components of `stack`. Where it comes from a renderer that does not keep emission apart, what looks like it
/// becomes a component of its own: a bright edge left in the scattered light spoils the local fits around it. A pixel is
/// moved when all buckets agree about it to the last bit, when it is bright and steady, or when every bucket saw a miss
/// (a normal of zero). How many there are is noted to `monitor`.
pub fn with_emission_apart<'a>(stack: &'a FeatureStack, monitor: &dyn Monitor) -> Cow<'a, [Component]> {
    let [Component { role: ComponentRole::Scattered, radiance }] = &stack.components[..] else {
        return Cow::Borrowed(&stack.components);
    };
    let Noise::Buckets(buckets) = &radiance.noise else { return Cow::Borrowed(&stack.components) };
    let moved = emissive(buckets, &stack.features);
    if moved.is_empty() {
        return Cow::Borrowed(&stack.components);
    }
    monitor.note(&format!("{} pixels look like directly seen emission and are rebuilt apart", moved.len()));
    let (scattered, emission) = separate(buckets.clone(), &moved);
    let component = |role, buckets| Component { role, radiance: Estimate::from_buckets(buckets, &stack.samples) };
    Cow::Owned(vec![component(ComponentRole::Scattered, scattered), component(ComponentRole::Emission, emission)])
}

/// Pixels that look like directly seen emission.
fn emissive(buckets: &[Image], features: &[Feature]) -> Vec<usize> {
    let median = median_brightness(&buckets[0]);
    let missed = misses(features);
    let looks_emissive = |pixel: &usize| {
        let luminance: Vec<f32> = buckets.iter().map(|bucket| bucket.mean_at(*pixel)).collect();
        luminance.iter().any(|l| *l > 0.0)
            && (missed.as_ref().is_some_and(|missed| missed[*pixel])
                || all_alike(buckets, *pixel)
                || is_lamp(&luminance, median))
    };
    (0..buckets[0].pixels()).filter(looks_emissive).collect()
}

/// Where every bucket of the normal is zero, when there is a normal.
fn misses(features: &[Feature]) -> Option<Vec<bool>> {
    let normal = features.iter().find(|feature| feature.role == FeatureRole::Normal)?;
    let Noise::Buckets(buckets) = &normal.estimate.noise else { return None };
    let zero = |pixel: usize| buckets.iter().all(|bucket| bucket.rgb(pixel) == [0.0; 3]);
    Some((0..normal.estimate.mean.pixels()).map(zero).collect())
}

fn all_alike(buckets: &[Image], pixel: usize) -> bool {
    buckets.iter().all(|bucket| bucket.rgb(pixel) == buckets[0].rgb(pixel))
}

fn is_lamp(luminance: &[f32], median: f32) -> bool {
    let mean = luminance.iter().sum::<f32>() / luminance.len() as f32;
    mean > BRIGHT * median && luminance.iter().all(|l| (l - mean).abs() < STEADY * mean)
}

fn separate(mut scattered: Vec<Image>, moved: &[usize]) -> (Vec<Image>, Vec<Image>) {
    let mut emission = vec![Image::zeros(scattered[0].size(), 3); scattered.len()];
    for (from, to) in scattered.iter_mut().zip(&mut emission) {
        for (from, to) in from.channels_mut().iter_mut().zip(to.channels_mut()) {
            for &pixel in moved {
                to[pixel] = std::mem::take(&mut from[pixel]);
            }
        }
    }
    (scattered, emission)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;
    use stack::{SampleCounts, Silent, Size, Window};

    const SIZE: Size = Size::new(8, 4);

    /// A noisy picture with a lamp pixel that every bucket agrees about.
    fn stack_with_lamp(components: impl Fn(Estimate) -> Vec<Component>) -> FeatureStack {
        let samples = SampleCounts::uniform(SIZE.pixels(), vec![4; 4]);
        let mut noise = TestNoise(3);
        let buckets = (0..4).map(|_| {
            let mut plane = noise.normals(SIZE.pixels(), 1.0, 0.1);
            plane[7] = 50.0;
            Image::from_channels(SIZE, vec![plane; 3])
        });
        let radiance = Estimate::from_buckets(buckets.collect(), &samples);
        let (features, passthrough) = (Vec::new(), Vec::new());
        let window = Window::whole(SIZE);
        FeatureStack {
            window,
            film: SIZE,
            samples,
            components: components(radiance),
            indirect: None,
            gathered: None,
            features,
            passthrough,
        }
    }

    #[test]
    fn a_lamp_becomes_a_component_and_the_beauty_stays() {
        let stack = stack_with_lamp(|radiance| vec![Component { role: ComponentRole::Scattered, radiance }]);
        let components = with_emission_apart(&stack, &Silent).into_owned();
        let [scattered, emission] = &components[..] else { panic!("two components") };
        assert_eq!(emission.radiance.mean.rgb(7), [50.0; 3]);
        assert_eq!(emission.radiance.mean.rgb(6), [0.0; 3]);
        assert_eq!(scattered.radiance.mean.rgb(7), [0.0; 3]);
        assert_eq!(FeatureStack { components, ..stack.clone() }.beauty(), stack.beauty());
    }

    #[test]
    fn what_is_apart_already_stays_as_it_is() {
        let stack = stack_with_lamp(|radiance| {
            ComponentRole::ALL.map(|role| Component { role, radiance: radiance.clone() }).to_vec()
        });
        assert!(matches!(with_emission_apart(&stack, &Silent), Cow::Borrowed(_)));
    }
}
