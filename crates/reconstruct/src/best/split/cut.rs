//! Buckets cut into a low layer and events, eight pixels at a time.

use stack::{GroupCounts, Image};

use crate::eight::{LANES, Lanes};
use crate::per_pixel::{ByEight, Pixels};

/// Buckets to be cut.
pub struct Cut<'a> {
    pub buckets: &'a [Image],
    /// Of each bucket; [`NOTHING`](super::high_ranks::NOTHING) where there is no sample.
    pub luminances: &'a [Vec<f32>],
    /// What each pixel is cut at.
    pub caps: &'a [f32],
    /// Samples of each bucket, and of each half.
    pub counts: GroupCounts<'a>,
    pub halves: &'a GroupCounts<'a>,
}

impl ByEight<17> for Cut<'_> {
    /// Halves, variance of a half (NaN with fewer than two filled buckets), light cut off either half, energy, squares.
    #[inline(always)]
    fn numbers(&self, pixels: Pixels) -> [Lanes; 17] {
        let Self { buckets, halves: of_halves, .. } = self;
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
        let Self { buckets, luminances, counts, .. } = self;
        let (caps, luminance) = (pixels.of(self.caps), pixels.of(&luminances[number]));
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
