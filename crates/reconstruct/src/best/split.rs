//! Light split into a low layer, which a regression can follow, and events, which it cannot.
//!
//! This is the paper's split into low rank and sparse (its section 4.1) where the assumption holds: across buckets the
//! truth is the same and a firefly is in one of them.

mod alone;
mod caps;
mod cut;
mod high_ranks;
mod layers;
mod sparse;

use rayon::prelude::*;
use stack::{Component, Dealing, Estimate, GroupCounts, Image, Noise, SampleCounts, Size};

use super::settings::SplitSettings;
use crate::per_pixel::planes_by_eight;
use crate::reconstruction::ReconstructError;
use crate::variance::{known_everywhere, steadied};
use alone::split_alone;
use caps::caps;
use cut::Cut;
use high_ranks::NOTHING;
use layers::LEAST_VARIANCE;
pub use layers::{Events, Layers, LowLayer};

/// Splits `component`: by its buckets, or, where nothing but a variance is known of its noise, by its neighbours alone.
///
/// # Errors
/// When nothing is known of it.
pub fn split(
    component: &Component,
    counts: &SampleCounts,
    settings: &SplitSettings,
) -> Result<Layers, ReconstructError> {
    let Estimate { mean, noise } = &component.radiance;
    match noise {
        Noise::Buckets(buckets) => Ok(split_buckets(mean.size(), buckets, counts, settings)),
        Noise::VarianceOfMean(variance) => Ok(split_alone(mean, variance)),
        Noise::Unknown => Err(ReconstructError::NoBuckets { layer: component.role.layer() }),
    }
}

fn split_buckets(size: Size, buckets: &[Image], counts: &SampleCounts, settings: &SplitSettings) -> Layers {
    // Our own differ by a sample or so where they come in pairs of buckets.
    let may_differ = !matches!(counts.dealing, Dealing::Numbered { .. }) || buckets.len() % 2 == 1;
    let (of_halves, of_buckets) = (counts.grouped(2), counts.grouped(buckets.len()));
    let luminances: Vec<Vec<f32>> = (0..buckets.len())
        .into_par_iter()
        .map(|bucket| (0..size.pixels()).map(|pixel| luminance(buckets, &of_buckets, bucket, pixel)).collect())
        .collect();
    let caps = caps(size, &luminances, counts, settings);
    let cut = Cut { buckets, luminances: &luminances, caps: &caps, counts: of_buckets, halves: &of_halves };
    let mut planes = planes_by_eight(size.pixels(), &cut).into_iter();
    let mut image = || Image::from_channels(size, planes.by_ref().take(3).collect());
    let mut halves = [image(), image()];
    if may_differ {
        balance(&mut halves, &of_halves);
    }
    let variance = known_everywhere(image(), &halves[0]);
    let light = [image(), image()];
    Layers {
        low: LowLayer { halves, variance: steadied(variance, LEAST_VARIANCE) },
        events: Events { light, energy: planes.next().unwrap_or_default(), squares: planes.next().unwrap_or_default() },
    }
}

/// No half counts as more than so many times the other: noise of light is skewed, so that turned halves are not independent
/// for being uncorrelated, and a firefly of a much longer one would be in both.
const MOST_UNEVEN: f32 = 2.0;

/// Makes both halves ones of equal variance.
fn balance([first, second]: &mut [Image; 2], counts: &GroupCounts) {
    for (xs, ys) in first.channels_mut().iter_mut().zip(second.channels_mut()) {
        for (pixel, (x, y)) in xs.iter_mut().zip(ys).enumerate() {
            [*x, *y] = balanced([*x, *y], [0, 1].map(|half| counts.of(pixel, half) as f32));
        }
    }
}

/// Halves `[x, y]` of `[a, b]` samples made ones of equal variance whose mean is that of all samples. With
/// m = (a x + b y)/n and d = x − y, whose noise is uncorrelated, m ± d √(a b)/n have variance 2σ²/n each and are
/// uncorrelated, too. A half that is longer than [`MOST_UNEVEN`] allows counts as if it were not.
fn balanced([x, y]: [f32; 2], [a, b]: [f32; 2]) -> [f32; 2] {
    // A half without samples repeats the other.
    if a == b || a * b == 0.0 {
        return [x, y];
    }
    let [a, b] = [a.min(MOST_UNEVEN * b), b.min(MOST_UNEVEN * a)];
    let n = a + b;
    [1.0, -1.0].map(|side| (a * x + b * y) / n + side * (x - y) * (a * b).sqrt() / n)
}

/// Luminance of one bucket.
fn luminance(buckets: &[Image], counts: &GroupCounts, bucket: usize, pixel: usize) -> f32 {
    if counts.of(pixel, bucket) > 0 { buckets[bucket].mean_at(pixel).max(0.0) } else { NOTHING }
}

#[cfg(test)]
mod tests;
