//! Finds directly seen lamps and backgrounds in a stack that has no emission layer.

use crate::{Component, ComponentRole, Estimate, Feature, FeatureRole, Image, Noise, SampleCounts};

/// A lamp is at least this many times as bright as the median pixel …
const BRIGHT: f32 = 5.0;

/// … and its buckets differ by no more than this share of their mean.
const STEADY: f32 = 0.02;

/// Moves what looks like directly seen emission to a component of its own: a bright edge left in the scattered light
/// spoils the fits around it. A pixel is moved when all buckets agree about it to the last bit, when it is bright and
/// steady, or when every bucket saw a miss (a normal of zero). `notes` gets a line when there is any.
pub fn split_emission(
    buckets: Vec<Image>,
    features: &[Feature],
    samples: &SampleCounts,
    notes: &mut Vec<String>,
) -> Vec<Component> {
    let median = median_luminance(&buckets);
    let missed = misses(features);
    let moved: Vec<usize> = (0..buckets[0].pixels())
        .filter(|&pixel| {
            let luminance: Vec<f32> = buckets.iter().map(|bucket| bucket.mean_at(pixel)).collect();
            luminance.iter().any(|l| *l > 0.0)
                && (missed.as_ref().is_some_and(|missed| missed[pixel])
                    || all_alike(&buckets, pixel)
                    || is_lamp(&luminance, median))
        })
        .collect();
    let component = |role, buckets| Component { role, radiance: Estimate::from_buckets(buckets, samples) };
    if moved.is_empty() {
        return vec![component(ComponentRole::Scattered, buckets)];
    }
    notes.push(format!("{} pixels look like directly seen emission and are rebuilt apart", moved.len()));
    let (scattered, emission) = separate(buckets, &moved);
    vec![component(ComponentRole::Scattered, scattered), component(ComponentRole::Emission, emission)]
}

fn median_luminance(buckets: &[Image]) -> f32 {
    let mut luminance: Vec<f32> = (0..buckets[0].pixels()).map(|pixel| buckets[0].mean_at(pixel)).collect();
    luminance.sort_by(f32::total_cmp);
    luminance[luminance.len() / 2]
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
