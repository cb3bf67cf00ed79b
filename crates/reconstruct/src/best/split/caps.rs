//! What a pixel's buckets are cut at.

use rayon::prelude::*;
use stack::{SampleCounts, Size};

use super::high_ranks::{HighRanks, Ranks, above_quartile, high_ranks};
use super::sparse::rises;
use crate::best::settings::SplitSettings;
use crate::box_filter::box_mean_twice;
use crate::per_pixel;
use crate::rectangle::Rectangle;

/// Least luminance that anything is cut at.
const LEAST_CAP: f32 = 1e-4;

/// How far evening out may move what surroundings reach, down and up: shadows and highlights keep most of theirs.
const MOVED: [f32; 2] = [0.6, 4.0];

/// Luminance above which each pixel's buckets are cut: a multiple of what the surroundings reach, evened out; more where
/// a quarter of its own buckets do, as far as that is no chance. `luminances` of the buckets of an image of `size` are
/// ≥ 0, or `NOTHING` where there is no sample.
pub fn caps(size: Size, luminances: &[Vec<f32>], samples: &SampleCounts, settings: &SplitSettings) -> Vec<f32> {
    Task { size, luminances, samples, settings }.caps()
}

struct Task<'a> {
    size: Size,
    luminances: &'a [Vec<f32>],
    samples: &'a SampleCounts,
    settings: &'a SplitSettings,
}

impl Task<'_> {
    fn caps(&self) -> Vec<f32> {
        let SplitSettings { radius, quantile, factor, .. } = *self.settings;
        let ranks = Ranks { radius, share: quantile };
        let high = high_ranks(self.size, self.luminances, ranks).unwrap_or_else(|| self.selected(ranks));
        let around = self.higher_where_few(self.evened_out(&high.around));
        let cap = |(pixel, (around, own)): (usize, (&f32, &f32))| {
            let reached = factor * around;
            let cap = if *own > reached { self.of_bright_pixel(pixel, reached, *own) } else { reached };
            cap.max(LEAST_CAP)
        };
        let mut caps: Vec<f32> = around.par_iter().zip(&high.own).enumerate().map(cap).collect();
        if let Some(rises) = rises(self.size, self.luminances, &caps, self.settings.most) {
            caps.iter_mut().zip(rises).for_each(|(cap, rise)| *cap *= rise);
        }
        caps
    }

    /// What surroundings reach, in the geometric mean over wide surroundings.
    fn evened_out(&self, reached: &[f32]) -> Vec<f32> {
        let radius = self.settings.smoothing;
        if radius == 0 {
            return reached.to_vec();
        }
        let logarithms: Vec<f32> = reached.par_iter().map(|v| v.max(LEAST_CAP).ln()).collect();
        let smooth = box_mean_twice(&logarithms, self.size, radius);
        let [least, most] = MOVED;
        let moved = |(smooth, v): (&f32, &f32)| smooth.exp().clamp(least * v, most * v.max(LEAST_CAP));
        smooth.par_iter().zip(reached).map(moved).collect()
    }

    /// The same where pixels have fewer samples than those around them, as much higher as a bucket of so few may be.
    fn higher_where_few(&self, mut reached: Vec<f32>) -> Vec<f32> {
        let SplitSettings { few, smoothing, radius, .. } = *self.settings;
        if few == 0.0 || self.samples.is_uniform() {
            return reached;
        }
        let samples: Vec<f32> = self.samples.total.iter().map(|n| *n as f32).collect();
        let around = box_mean_twice(&samples, self.size, smoothing.max(radius));
        let pixels = reached.par_iter_mut().zip(&samples).zip(&around);
        pixels.for_each(|((reached, own), around)| *reached *= (around / own.max(1.0)).max(1.0).powf(few));
        reached
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

    /// What a pixel is cut at whose upper quartile is above what the surroundings have `reached`: the quartile, as far as
    /// its bright buckets are likely a detail of the picture, in which any number of them is as likely as any other, and did not
    /// meet by chance, at the rate of the other buckets around. Where all met by chance, as both of two halves may, none tells
    /// what else is there, and cut alike they would pass for a detail without noise: the median around stands for it.
    fn of_bright_pixel(&self, pixel: usize, reached: f32, quartile: f32) -> f32 {
        let (own, mut around) = (self.own(pixel), self.surroundings(pixel));
        let above = |values: &[f32]| values.iter().filter(|l| **l > reached).count();
        let bright = above(&own);
        let (others_bright, others) = (above(&around) - bright, around.len() - own.len());
        let rate = (others_bright as f32 + 0.5) / (others as f32 + 1.0);
        let prior = self.settings.detail / (own.len() + 1) as f32;
        let detail = prior / (prior + binomial(bright, own.len(), rate)).max(f32::MIN_POSITIVE);
        let chance = if bright == own.len() {
            let middle = around.len() / 2;
            reached.min(*around.select_nth_unstable_by(middle, f32::total_cmp).1)
        } else {
            reached
        };
        (1.0 - detail) * chance + detail * quartile
    }

    /// Luminances of a pixel's filled buckets.
    fn own(&self, pixel: usize) -> Vec<f32> {
        self.luminances.iter().map(|bucket| bucket[pixel]).filter(|l| *l >= 0.0).collect()
    }

    /// The same of a pixel and those around it.
    fn surroundings(&self, pixel: usize) -> Vec<f32> {
        let place = [pixel % self.size.width, pixel / self.size.width];
        let window = Rectangle::around(place, self.settings.radius, self.size);
        let mut values = Vec::with_capacity(window.width() * window.height() * self.luminances.len());
        for row in window.y0..window.y1 {
            let near = self.size.index(window.x0, row);
            for luminances in self.luminances {
                values.extend(luminances[near..][..window.width()].iter().filter(|l| **l >= 0.0));
            }
        }
        values
    }
}

/// The chance that `k` of `n` events occur, each of which does with probability `p`.
pub fn binomial(k: usize, n: usize, p: f32) -> f32 {
    let ways: f32 = (0..k).map(|i| (n - i) as f32 / (i + 1) as f32).product();
    ways * p.powi(k as i32) * (1.0 - p).powi((n - k) as i32)
}
