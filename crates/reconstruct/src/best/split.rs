//! Light split into a low layer, which a regression can follow, and events, which it cannot.
//!
//! This is the paper's split into low rank and sparse (its section 4.1) where the assumption holds: across buckets the
//! truth is the same and a firefly is in one of them.

use std::ops::Range;

use rayon::prelude::*;
use stack::{Component, Dealing, GroupCounts, Image, Noise, SampleCounts, Size};

use super::settings::SplitSettings;
use crate::bands::{image_rows, rows_of};
use crate::per_pixel;
use crate::reconstruction::ReconstructError;
use crate::variance::{known_everywhere, steadied};

/// Least variance of a half.
pub const LEAST_VARIANCE: f32 = 1e-7;

/// Least luminance that anything is cut at.
const LEAST_CAP: f32 = 1e-4;

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

    /// Σ over halves and channels of (x − y)² − v at `pixel`, x the value of one of `halves` and y the noisy one of the
    /// other half: twice the expected squared error of half a picture, if x knows nothing of y.
    pub fn cross_error(&self, halves: &[Image; 2], pixel: usize) -> f32 {
        let v = self.variance.rgb(pixel);
        let of_half = |half: usize| {
            let (x, y) = (halves[half].rgb(pixel), self.halves[1 - half].rgb(pixel));
            (0..3).map(|c| (x[c] - y[c]).powi(2) - v[c]).sum::<f32>()
        };
        of_half(0) + of_half(1)
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
    let (halves, counts) = (counts.grouped(2), counts.grouped(buckets.len()));
    let luminances: Vec<Vec<f32>> = (0..buckets.len())
        .into_par_iter()
        .map(|bucket| (0..size.pixels()).map(|pixel| luminance(buckets, &counts, bucket, pixel)).collect())
        .collect();
    let task = SplitTask { size, buckets, luminances: &luminances, counts, halves, may_differ, settings };
    let mut planes = per_pixel::planes(size.pixels(), |pixel| task.pixel(pixel).numbers()).into_iter();
    let mut image = || Image::from_channels(size, planes.by_ref().take(3).collect());
    let halves = [image(), image()];
    let variance = known_everywhere(image(), &halves[0]);
    let light = [image(), image()];
    Ok(Layers {
        halves,
        variance: steadied(variance, LEAST_VARIANCE),
        events: Events { light, energy: planes.next().unwrap_or_default(), squares: planes.next().unwrap_or_default() },
    })
}

/// Luminance of one bucket; −1 where it has no samples.
fn luminance(buckets: &[Image], counts: &GroupCounts, bucket: usize, pixel: usize) -> f32 {
    if counts.of(pixel, bucket) > 0 { buckets[bucket].mean_at(pixel).max(0.0) } else { -1.0 }
}

/// Values kept apart while looking for a high quantile.
const TOP: usize = 16;

/// The `share` quantile (0 to 1) of `values`, rounded down; 0 when there are none.
fn quantile(values: &mut [f32], share: f32) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = ((values.len() - 1) as f32 * share) as usize;
    let above = values.len() - 1 - rank;
    if above >= TOP {
        return *values.select_nth_unstable_by(rank, f32::total_cmp).1;
    }
    // Few are larger: a short sorted list of the largest so far is faster than any selection.
    let mut largest = [f32::NEG_INFINITY; TOP];
    for value in values.iter().copied() {
        if value > largest[above] {
            let place = largest[..above].partition_point(|l| *l > value);
            largest[place..=above].rotate_right(1);
            largest[place] = value;
        }
    }
    largest[above]
}

#[derive(Clone, Copy, Debug, Default)]
struct SplitPixel {
    halves: [[f32; 3]; 2],
    variance: [f32; 3],
    light: [[f32; 3]; 2],
    energy: f32,
    squares: f32,
}

impl SplitPixel {
    /// Halves, variance, light of either half, energy, squares.
    fn numbers(&self) -> [f32; 17] {
        let mut numbers = [0.0; 17];
        let [a, b] = self.halves;
        let [cut_a, cut_b] = self.light;
        for (i, values) in [a, b, self.variance, cut_a, cut_b].into_iter().enumerate() {
            numbers[3 * i..3 * i + 3].copy_from_slice(&values);
        }
        [numbers[15], numbers[16]] = [self.energy, self.squares];
        numbers
    }
}

/// The chance that `k` of `n` events occur, each of which does with probability `p`.
fn binomial(k: usize, n: usize, p: f32) -> f32 {
    let ways: f32 = (0..k).map(|i| (n - i) as f32 / (i + 1) as f32).product();
    ways * p.powi(k as i32) * (1.0 - p).powi((n - k) as i32)
}

struct SplitTask<'a> {
    size: Size,
    buckets: &'a [Image],
    luminances: &'a [Vec<f32>],
    counts: GroupCounts<'a>,
    halves: GroupCounts<'a>,
    /// Whether halves may hold very different numbers of samples.
    may_differ: bool,
    settings: &'a SplitSettings,
}

impl SplitTask<'_> {
    fn samples(&self, pixel: usize, bucket: usize) -> f32 {
        self.counts.of(pixel, bucket) as f32
    }

    /// Luminance above which a bucket is cut: a multiple of what the surroundings reach; more where a quarter of the pixel's
    /// own buckets do, as far as that is no chance.
    fn cap(&self, pixel: usize) -> f32 {
        let mut around = self.surroundings(pixel);
        let reached = self.settings.factor * quantile(&mut around, self.settings.quantile);
        let mut own: Vec<f32> = self.filled(pixel).map(|bucket| self.luminances[bucket][pixel]).collect();
        // Never the largest: a firefly in one of two halves is the upper one.
        let quartile = (own.len() * 3 / 4).min(own.len().saturating_sub(2));
        let quartile = if own.is_empty() { 0.0 } else { *own.select_nth_unstable_by(quartile, f32::total_cmp).1 };
        let excess = (quartile - reached).max(0.0);
        let detail = if excess > 0.0 { self.is_detail(&own, &around, reached) } else { 0.0 };
        (reached + detail * excess).max(LEAST_CAP)
    }

    /// How likely it is, from 0 to 1, that those of a pixel's `own` buckets that are above `reached` are a detail of the
    /// picture, in which any number of them is as likely as any other, and did not meet by chance, at the rate of the
    /// other buckets `around`.
    fn is_detail(&self, own: &[f32], around: &[f32], reached: f32) -> f32 {
        let above = |values: &[f32]| values.iter().filter(|l| **l > reached).count();
        let bright = above(own);
        let (others_bright, others) = (above(around) - bright, around.len() - own.len());
        let rate = (others_bright as f32 + 0.5) / (others as f32 + 1.0);
        let detail = self.settings.detail / (own.len() + 1) as f32;
        detail / (detail + binomial(bright, own.len(), rate))
    }

    fn filled(&self, pixel: usize) -> impl Iterator<Item = usize> {
        (0..self.buckets.len()).filter(move |bucket| self.luminances[*bucket][pixel] >= 0.0)
    }

    /// Luminances of all buckets of a pixel and those around it.
    fn surroundings(&self, pixel: usize) -> Vec<f32> {
        let (x, y, radius) = (pixel % self.size.width, pixel / self.size.width, self.settings.radius);
        let columns = x.saturating_sub(radius)..(x + radius + 1).min(self.size.width);
        let mut values = Vec::with_capacity((2 * radius + 1).pow(2) * self.buckets.len());
        for row in y.saturating_sub(radius)..(y + radius + 1).min(self.size.height) {
            let near = self.size.index(columns.start, row);
            for luminances in self.luminances {
                values.extend(luminances[near..][..columns.len()].iter().filter(|l| **l >= 0.0));
            }
        }
        values
    }

    /// Share of a bucket's light that stays in the low layer.
    fn kept(&self, pixel: usize, bucket: usize, cap: f32) -> f32 {
        (cap / self.luminances[bucket][pixel].max(1e-9)).min(1.0)
    }

    fn pixel(&self, pixel: usize) -> SplitPixel {
        let cap = self.cap(pixel);
        let mut sums = BucketSums::default();
        for bucket in self.filled(pixel) {
            let radiance = self.buckets[bucket].rgb(pixel);
            let kept = self.kept(pixel, bucket, cap);
            sums.add(bucket, self.samples(pixel, bucket), radiance, kept);
        }
        let mut split = sums.finish();
        split.variance = self.variance(pixel, cap, &split.halves);
        if self.may_differ {
            split.halves = balanced(split.halves, [0, 1].map(|half| self.halves.of(pixel, half) as f32));
        }
        split
    }

    /// Variance of a half's mean, from the spread of the low layer's buckets; NaN with fewer than two.
    fn variance(&self, pixel: usize, cap: f32, halves: &[[f32; 3]; 2]) -> [f32; 3] {
        let [a, b] = [0, 1].map(|half| self.halves.of(pixel, half) as f32);
        let mut squares = [0.0; 3];
        for bucket in self.filled(pixel) {
            let radiance = self.buckets[bucket].rgb(pixel);
            let kept = self.kept(pixel, bucket, cap);
            for c in 0..3 {
                let mean = (a * halves[0][c] + b * halves[1][c]) / (a + b);
                squares[c] += self.samples(pixel, bucket) * (kept * radiance[c] - mean).powi(2);
            }
        }
        let filled = self.filled(pixel).count();
        let scale = if filled < 2 { f32::NAN } else { 2.0 / ((filled - 1) as f32 * (a + b)) };
        squares.map(|s| s * scale)
    }
}

/// No half counts as more than so many times the other: noise of light is skewed, so that turned halves are not independent
/// for being uncorrelated, and a firefly of a much longer one would be in both.
const MOST_UNEVEN: f32 = 2.0;

/// Halves of `[a, b]` samples made ones of equal variance whose mean is that of all samples. With m = (a A + b B)/n and
/// d = A − B, whose noise is uncorrelated, m ± d √(a b)/n have variance 2σ²/n each and are uncorrelated, too.
fn balanced(halves: [[f32; 3]; 2], [a, b]: [f32; 2]) -> [[f32; 3]; 2] {
    // A half without samples repeats the other.
    if a == b || a * b == 0.0 {
        return halves;
    }
    let [a, b] = [a.min(MOST_UNEVEN * b), b.min(MOST_UNEVEN * a)];
    let n = a + b;
    [1.0, -1.0].map(|side| {
        [0, 1, 2].map(|c| {
            let [x, y] = [halves[0][c], halves[1][c]];
            (a * x + b * y) / n + side * (x - y) * (a * b).sqrt() / n
        })
    })
}

/// Sums over the buckets of one pixel.
#[derive(Default)]
struct BucketSums {
    low: [[f32; 3]; 2],
    samples: [f32; 2],
    cut: [[f32; 3]; 2],
    energy: f32,
    squares: f32,
}

impl BucketSums {
    fn add(&mut self, bucket: usize, samples: f32, radiance: [f32; 3], kept: f32) {
        let half = bucket % 2;
        self.samples[half] += samples;
        for c in 0..3 {
            self.low[half][c] += samples * kept * radiance[c];
            self.cut[half][c] += samples * (1.0 - kept) * radiance[c];
        }
        let event = samples * (1.0 - kept) * radiance.iter().sum::<f32>();
        self.energy += event;
        self.squares += event * event;
    }

    /// A half without samples repeats the other.
    fn finish(self) -> SplitPixel {
        let total = self.samples[0] + self.samples[1];
        let half = |half: usize| if self.samples[half] > 0.0 { half } else { 1 - half };
        let halves = [half(0), half(1)].map(|half| self.low[half].map(|v| v / self.samples[half].max(1.0)));
        let light = self.cut.map(|cut| cut.map(|v| v / total.max(1.0)));
        SplitPixel { halves, light, energy: self.energy, squares: self.squares, ..SplitPixel::default() }
    }
}

#[cfg(test)]
mod tests;
