//! Light split into a low layer, which a regression can follow, and events, which it cannot.
//!
//! This is the paper's split into low rank and sparse (its section 4.1) where the assumption holds: across buckets the
//! truth is the same and a firefly is in one of them.

mod caps;
mod cut;
mod high_ranks;
mod sparse;

use std::ops::Range;

use rayon::prelude::*;
use stack::{Component, Dealing, GroupCounts, Image, Noise, SampleCounts};

use super::settings::SplitSettings;
use crate::bands::{image_rows, rows_of};
use crate::per_pixel::planes_by_eight;
use crate::reconstruction::ReconstructError;
use crate::variance::{known_everywhere, steadied};
use caps::caps;
use cut::Cut;
use high_ranks::NOTHING;

/// Least variance of a half.
pub const LEAST_VARIANCE: f32 = 1e-7;

/// A component in two layers.
#[derive(Clone, Debug)]
pub struct Layers {
    /// The low layer's half-buffers.
    pub halves: [Image; 2],
    /// Variance of a half's mean, ½ its own and ½ that of 3×3 pixels.
    pub variance: Image,
    /// What was cut off.
    pub events: Events,
}

/// The sparse layer. An event is what was cut off one bucket at one pixel.
#[derive(Clone, Debug)]
pub struct Events {
    /// What was cut off the buckets of either half, divided by all samples of the pixel; three channels each. Their sum
    /// is what the mean lacks.
    pub light: [Image; 2],
    /// Σ e over a pixel's events, e the RGB sum of one.
    pub energy: Vec<f32>,
    /// Σ e².
    pub squares: Vec<f32>,
}

impl Events {
    /// Σe²/(Σe)² of a pixel's events: one over how many equal ones they count for.
    pub fn concentration(&self, pixel: usize) -> f32 {
        self.squares[pixel] / (self.energy[pixel] * self.energy[pixel]).max(f32::MIN_POSITIVE)
    }
}

impl Layers {
    /// Some `rows` of both layers.
    pub fn rows(&self, rows: &Range<usize>) -> Self {
        let Self { halves, variance, events: Events { light, energy, squares } } = self;
        let [energy, squares] = [energy, squares].map(|plane| rows_of(plane, variance.size(), rows));
        let light = light.each_ref().map(|image| image_rows(image, rows));
        Self {
            halves: halves.each_ref().map(|image| image_rows(image, rows)),
            variance: image_rows(variance, rows),
            events: Events { light, energy, squares },
        }
    }
}

/// Splits `component`.
///
/// # Errors
/// When its noise does not come in buckets.
pub fn split(
    component: &Component,
    counts: &SampleCounts,
    settings: &SplitSettings,
) -> Result<Layers, ReconstructError> {
    let Noise::Buckets(buckets) = &component.radiance.noise else {
        return Err(ReconstructError::NoBuckets { layer: component.role.layer() });
    };
    let size = component.radiance.mean.size();
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
    Ok(Layers {
        halves,
        variance: steadied(variance, LEAST_VARIANCE),
        events: Events { light, energy: planes.next().unwrap_or_default(), squares: planes.next().unwrap_or_default() },
    })
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
