//! Light split into a low layer, which a regression can follow, and events, which it cannot.
//!
//! This is the paper's split into low rank and sparse (its section 4.1) where the assumption holds: across buckets the
//! truth is the same and a firefly is in one of them.

mod high_ranks;

use std::ops::Range;

use rayon::prelude::*;
use stack::{Component, Dealing, GroupCounts, Image, Noise, SampleCounts, Size};

use super::settings::SplitSettings;
use crate::bands::{image_rows, rows_of};
use crate::eight::LANES;
use crate::per_pixel::{self, ByEight, Pixels};
use crate::reconstruction::ReconstructError;
use crate::variance::{known_everywhere, steadied};
use high_ranks::{HighRanks, NOTHING, Ranks, above_quartile, high_ranks};

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
    let (of_halves, counts) = (counts.grouped(2), counts.grouped(buckets.len()));
    let luminances: Vec<Vec<f32>> = (0..buckets.len())
        .into_par_iter()
        .map(|bucket| (0..size.pixels()).map(|pixel| luminance(buckets, &counts, bucket, pixel)).collect())
        .collect();
    let task = SplitTask { size, buckets, luminances: &luminances, counts, halves: &of_halves, settings };
    let caps = task.caps();
    let mut planes = per_pixel::planes_by_eight(size.pixels(), &Cut { task, caps }).into_iter();
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
/// uncorrelated, too.
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
    halves: &'a GroupCounts<'a>,
    settings: &'a SplitSettings,
}

impl SplitTask<'_> {
    /// Luminance above which a pixel's buckets are cut: a multiple of what the surroundings reach; more where a quarter of
    /// its own buckets do, as far as that is no chance.
    fn caps(&self) -> Vec<f32> {
        let SplitSettings { radius, quantile, factor, .. } = *self.settings;
        let ranks = Ranks { radius, share: quantile };
        let high = high_ranks(self.size, self.luminances, ranks).unwrap_or_else(|| self.selected(ranks));
        let cap = |(pixel, (around, own)): (usize, (&f32, &f32))| {
            let reached = factor * around;
            let excess = (own - reached).max(0.0);
            let detail = if excess > 0.0 { self.is_detail(pixel, reached) } else { 0.0 };
            (reached + detail * excess).max(LEAST_CAP)
        };
        high.around.par_iter().zip(&high.own).enumerate().map(cap).collect()
    }

    /// Both ranks pixel by pixel, however deep they lie.
    fn selected(&self, ranks: Ranks) -> HighRanks {
        let select = |values: &mut [f32], above: usize| match values.len() {
            0 => 0.0,
            count => *values.select_nth_unstable_by(count - 1 - above, f32::total_cmp).1,
        };
        let [around, own] = per_pixel::planes(self.size.pixels(), |pixel| {
            let (mut around, mut own) = (self.surroundings(pixel), self.own(pixel));
            let above = [ranks.above(around.len()), above_quartile(own.len())];
            [select(&mut around, above[0]), select(&mut own, above[1])]
        });
        HighRanks { around, own }
    }

    /// How likely it is, from 0 to 1, that those of a pixel's buckets that are above `reached` are a detail of the
    /// picture, in which any number of them is as likely as any other, and did not meet by chance, at the rate of the
    /// other buckets around.
    fn is_detail(&self, pixel: usize, reached: f32) -> f32 {
        let (own, around) = (self.own(pixel), self.surroundings(pixel));
        let above = |values: &[f32]| values.iter().filter(|l| **l > reached).count();
        let bright = above(&own);
        let (others_bright, others) = (above(&around) - bright, around.len() - own.len());
        let rate = (others_bright as f32 + 0.5) / (others as f32 + 1.0);
        let detail = self.settings.detail / (own.len() + 1) as f32;
        detail / (detail + binomial(bright, own.len(), rate))
    }

    /// Luminances of a pixel's filled buckets.
    fn own(&self, pixel: usize) -> Vec<f32> {
        self.luminances.iter().map(|bucket| bucket[pixel]).filter(|l| *l >= 0.0).collect()
    }

    /// The same of a pixel and those around it.
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
}

/// Buckets to be cut.
struct Cut<'a> {
    task: SplitTask<'a>,
    caps: Vec<f32>,
}

impl ByEight<17> for Cut<'_> {
    /// Halves, variance of a half (NaN with fewer than two filled buckets), light cut off either half, energy, squares.
    #[inline(always)]
    fn numbers(&self, pixels: Pixels) -> [Lanes; 17] {
        let SplitTask { buckets, halves: of_halves, .. } = &self.task;
        let mut sums = Sums::default();
        for number in 0..buckets.len() {
            sums.add(number % 2, &self.bucket(number, pixels));
        }
        let total = [0, 1].map(|half| pixels.map(|pixel| of_halves.of(pixel, half) as f32));
        let halves = sums.halves();
        let mean = mean_of_halves(&halves, &total);
        let mut squares = [[0.0; LANES]; 3];
        for number in 0..buckets.len() {
            let bucket = self.bucket(number, pixels);
            for c in 0..3 {
                for i in 0..LANES {
                    let difference = bucket.kept[i] * bucket.radiance[c][i] - mean[c][i];
                    squares[c][i] += bucket.samples[i] * (difference * difference);
                }
            }
        }
        let mut planes = [[0.0; LANES]; 17];
        for c in 0..3 {
            [planes[c], planes[3 + c]] = [halves[0][c], halves[1][c]];
            for i in 0..LANES {
                let scale = 2.0 / ((sums.filled[i] - 1.0) * (total[0][i] + total[1][i]));
                planes[6 + c][i] = if sums.filled[i] < 2.0 { f32::NAN } else { squares[c][i] * scale };
                let samples = (sums.samples[0][i] + sums.samples[1][i]).max(1.0);
                planes[9 + c][i] = sums.cut[0][c][i] / samples;
                planes[12 + c][i] = sums.cut[1][c][i] / samples;
            }
        }
        [planes[15], planes[16]] = [sums.energy, sums.squares];
        planes
    }
}

impl Cut<'_> {
    /// Bucket `number` of eight pixels; one without samples holds nothing.
    #[inline(always)]
    fn bucket(&self, number: usize, pixels: Pixels) -> Bucket {
        let SplitTask { buckets, luminances, counts, .. } = &self.task;
        let (caps, luminance) = (pixels.of(&self.caps), pixels.of(&luminances[number]));
        let mut samples = pixels.map(|pixel| counts.of(pixel, number) as f32);
        let [mut kept, mut filled] = [[0.0; LANES]; 2];
        let mut radiance = [[0.0; LANES]; 3];
        radiance.iter_mut().zip(buckets[number].channels()).for_each(|(lanes, plane)| *lanes = pixels.of(plane));
        for i in 0..LANES {
            let held = luminance[i] >= 0.0;
            let share = caps[i] / luminance[i].max(1e-9);
            kept[i] = if share < 1.0 { share } else { 1.0 };
            filled[i] = if held { 1.0 } else { 0.0 };
            samples[i] = if held { samples[i] } else { 0.0 };
            for c in 0..3 {
                radiance[c][i] = if held { radiance[c][i] } else { 0.0 };
            }
        }
        Bucket { samples, filled, radiance, kept }
    }
}

/// A number of each of eight pixels.
type Lanes = [f32; LANES];

/// A bucket of eight pixels.
struct Bucket {
    samples: Lanes,
    /// 1 where it has any.
    filled: Lanes,
    radiance: [Lanes; 3],
    /// Share of its light that stays in the low layer.
    kept: Lanes,
}

/// Sums over the buckets of eight pixels.
#[derive(Default)]
struct Sums {
    /// Samples and what they hold, by halves.
    samples: [Lanes; 2],
    low: [[Lanes; 3]; 2],
    cut: [[Lanes; 3]; 2],
    filled: Lanes,
    energy: Lanes,
    squares: Lanes,
}

impl Sums {
    #[inline(always)]
    fn add(&mut self, half: usize, bucket: &Bucket) {
        let Bucket { samples, filled, radiance, kept } = bucket;
        let mut event = [0.0; LANES];
        for c in 0..3 {
            for i in 0..LANES {
                let light = samples[i] * radiance[c][i];
                let cut = (1.0 - kept[i]) * light;
                self.low[half][c][i] += kept[i] * light;
                self.cut[half][c][i] += cut;
                event[i] += cut;
            }
        }
        for i in 0..LANES {
            self.samples[half][i] += samples[i];
            self.filled[i] += filled[i];
            self.energy[i] += event[i];
            self.squares[i] += event[i] * event[i];
        }
    }

    /// Means of the low layer's halves; one without samples repeats the other.
    #[inline(always)]
    fn halves(&self) -> [[Lanes; 3]; 2] {
        let mut halves = self.low;
        for (half, out) in halves.iter_mut().enumerate() {
            let (own, other) = (self.samples[half], self.samples[1 - half]);
            for c in 0..3 {
                for i in 0..LANES {
                    let (low, samples) = (self.low[half][c][i], self.low[1 - half][c][i]);
                    out[c][i] = if own[i] > 0.0 { low / own[i] } else { samples / other[i].max(1.0) };
                }
            }
        }
        halves
    }
}

/// The mean of `halves` of so many `samples`.
#[inline(always)]
fn mean_of_halves([a, b]: &[[Lanes; 3]; 2], [of_a, of_b]: &[Lanes; 2]) -> [Lanes; 3] {
    let mut mean = *a;
    for c in 0..3 {
        for i in 0..LANES {
            mean[c][i] = (of_a[i] * a[c][i] + of_b[i] * b[c][i]) / (of_a[i] + of_b[i]);
        }
    }
    mean
}

#[cfg(test)]
mod tests;
