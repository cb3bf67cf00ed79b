//! High ranks among all buckets of the pixels around each pixel.
//!
//! A window shares most of its pixels with its neighbours', so the largest values of every pixel are sorted once, merged
//! along columns, and then along rows; eight pixels side by side, with comparisons that do not branch.

use rayon::prelude::*;
use stack::Size;

use crate::eight::{LANES, Lanes};
use crate::per_pixel::{ByEight, Pixels, planes_by_eight};

/// Stands for a bucket without samples: below all that are filled.
pub const NOTHING: f32 = -1.0;

/// What a pixel's buckets and those around it reach.
#[derive(Debug)]
pub struct HighRanks {
    /// Quantile of all buckets in the window, rounded down; 0 where none is filled.
    pub around: Vec<f32>,
    /// Upper quartile of the pixel's own.
    pub own: Vec<f32>,
}

/// Which ranks are asked for.
#[derive(Clone, Copy, Debug)]
pub struct Ranks {
    /// Radius of the window, in pixels.
    pub radius: usize,
    /// The quantile, 0 to 1.
    pub share: f32,
}

impl Ranks {
    /// How many of `count` values are above the quantile.
    pub fn above(self, count: usize) -> usize {
        let last = count.saturating_sub(1);
        last - ((last as f32 * self.share) as usize).min(last)
    }
}

/// How many of a pixel's `count` values are above their upper quartile. Never none of two or more: a firefly in one of
/// two halves is the upper one.
pub fn above_quartile(count: usize) -> usize {
    let last = count.saturating_sub(1);
    last - (count * 3 / 4).min(count.saturating_sub(2)).min(last)
}

/// Both ranks at every pixel of `buckets`, whose values are ≥ 0 or [`NOTHING`]. `None` where they lie so deep that
/// lists of the largest values do not hold them.
pub fn high_ranks(size: Size, buckets: &[Vec<f32>], ranks: Ranks) -> Option<HighRanks> {
    let window = (2 * ranks.radius + 1).pow(2) * buckets.len();
    match ranks.above(window).max(above_quartile(buckets.len())) {
        0..8 => Some(with_lists::<8>(size, buckets, ranks)),
        8..16 => Some(with_lists::<16>(size, buckets, ranks)),
        _ => None,
    }
}

fn with_lists<const D: usize>(size: Size, buckets: &[Vec<f32>], ranks: Ranks) -> HighRanks {
    let lists = planes_by_eight::<D>(size.pixels(), &Largest(buckets));
    let filled = |pixel: usize| buckets.iter().filter(|bucket| bucket[pixel] >= 0.0).count() as u32;
    let filled: Vec<u32> = (0..size.pixels()).into_par_iter().map(filled).collect();
    let own = |(pixel, count): (usize, &u32)| {
        if *count > 0 { lists[above_quartile(*count as usize)][pixel] } else { 0.0 }
    };
    let own = filled.par_iter().enumerate().map(own).collect();
    let mut around = vec![0.0; size.pixels()];
    if size.width > 0 {
        around.par_chunks_mut(size.width).enumerate().for_each(|(y, out)| {
            pulp::Arch::new().dispatch(RowTask { size, lists: &lists, filled: &filled, ranks, y, out });
        });
    }
    HighRanks { around, own }
}

/// The largest values of a pixel's buckets, in descending order.
struct Largest<'a>(&'a [Vec<f32>]);

impl<const D: usize> ByEight<D> for Largest<'_> {
    #[inline(always)]
    fn numbers(&self, pixels: Pixels) -> [Lanes; D] {
        let mut list = [[NOTHING; LANES]; D];
        for bucket in self.0 {
            let mut value = pixels.of(bucket);
            for place in &mut list {
                (*place, value) = ordered(*place, value);
            }
        }
        list
    }
}

/// The larger of both, and the smaller.
#[inline(always)]
fn ordered(a: Lanes, b: Lanes) -> (Lanes, Lanes) {
    let (mut larger, mut smaller) = (a, b);
    for i in 0..LANES {
        larger[i] = if a[i] > b[i] { a[i] } else { b[i] };
        smaller[i] = if a[i] > b[i] { b[i] } else { a[i] };
    }
    (larger, smaller)
}

/// The `D` largest of two descending lists: the larger ones of opposite places fall and rise, or rise and fall, and are
/// ordered as such a list is (Batcher 1968).
#[inline(always)]
fn merged<const D: usize>(a: &[Lanes; D], b: &[Lanes; D]) -> [Lanes; D] {
    let mut list = *a;
    for i in 0..D {
        list[i] = ordered(a[i], b[D - 1 - i]).0;
    }
    let mut gap = D / 2;
    while gap > 0 {
        for i in (0..D).filter(|i| i & gap == 0) {
            (list[i], list[i + gap]) = ordered(list[i], list[i + gap]);
        }
        gap /= 2;
    }
    list
}

/// One row of a picture.
struct RowTask<'a, const D: usize> {
    size: Size,
    /// Lists of all pixels, a plane for each place.
    lists: &'a [Vec<f32>; D],
    /// How many buckets of each pixel are filled.
    filled: &'a [u32],
    ranks: Ranks,
    y: usize,
    out: &'a mut [f32],
}

impl<const D: usize> pulp::NullaryFnOnce for RowTask<'_, D> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { size, lists, filled, ranks: Ranks { radius, .. }, y, .. } = self;
        let rows = y.saturating_sub(radius)..(y + radius + 1).min(size.height);
        // Columns beyond both ends hold nothing.
        let length = size.width.next_multiple_of(LANES) + 2 * radius;
        let mut columns = vec![NOTHING; D * length];
        let mut counts = vec![0; size.width];
        for row in rows {
            counts.iter_mut().zip(&filled[row * size.width..]).for_each(|(count, filled)| *count += filled);
            for x in (0..size.width).step_by(LANES) {
                let width = LANES.min(size.width - x);
                let mut there = [[NOTHING; LANES]; D];
                for (place, plane) in there.iter_mut().zip(lists) {
                    place[..width].copy_from_slice(&plane[size.index(x, row)..][..width]);
                }
                let merged = merged(&at::<D>(&columns, length, radius + x), &there);
                for (place, values) in merged.iter().enumerate() {
                    columns[place * length + radius + x..][..width].copy_from_slice(&values[..width]);
                }
            }
        }
        for x in (0..size.width).step_by(LANES) {
            let mut list = at::<D>(&columns, length, x);
            for shift in 1..=2 * radius {
                list = merged(&list, &at(&columns, length, x + shift));
            }
            for i in 0..LANES.min(size.width - x) {
                let near = (x + i).saturating_sub(radius)..(x + i + radius + 1).min(size.width);
                let count: u32 = counts[near].iter().sum();
                self.out[x + i] = if count > 0 { list[self.ranks.above(count as usize)][i] } else { 0.0 };
            }
        }
    }
}

/// Lists of eight columns.
#[inline(always)]
fn at<const D: usize>(columns: &[f32], length: usize, x: usize) -> [Lanes; D] {
    let mut list = [[0.0; LANES]; D];
    for (place, values) in list.iter_mut().enumerate() {
        values.copy_from_slice(&columns[place * length + x..][..LANES]);
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;

    /// The ranks by sorting all values of a window.
    fn by_sorting(size: Size, buckets: &[Vec<f32>], ranks: Ranks) -> HighRanks {
        let near = |a: usize, b: usize| a.abs_diff(b) <= ranks.radius;
        let values = |within: &dyn Fn(usize) -> bool| {
            let pixels: Vec<usize> = (0..size.pixels()).filter(|pixel| within(*pixel)).collect();
            let all = buckets.iter().flat_map(|bucket| pixels.iter().map(|pixel| bucket[*pixel]));
            let mut values: Vec<f32> = all.filter(|v| *v >= 0.0).collect();
            values.sort_by(|a, b| b.total_cmp(a));
            values
        };
        let around = |i: usize| {
            let (x, y) = (i % size.width, i / size.width);
            let values = values(&|j| near(j % size.width, x) && near(j / size.width, y));
            values.get(ranks.above(values.len())).copied().unwrap_or(0.0)
        };
        let own = |i: usize| {
            let values = values(&|j| j == i);
            values.get(above_quartile(values.len())).copied().unwrap_or(0.0)
        };
        HighRanks { around: (0..size.pixels()).map(around).collect(), own: (0..size.pixels()).map(own).collect() }
    }

    #[test]
    fn ranks_are_those_of_sorted_values() {
        let mut noise = TestNoise(7);
        for (count, radius, share) in [(8, 2, 0.97), (2, 2, 0.97), (3, 1, 0.8), (16, 2, 0.97), (8, 1, 1.0), (1, 2, 0.9)]
        {
            for size in [Size::new(21, 9), Size::new(1, 4), Size::new(3, 1)] {
                let mut value = || if noise.uniform() < 0.2 { NOTHING } else { noise.uniform().powi(3) as f32 };
                let mut plane = || (0..size.pixels()).map(|_| value()).collect();
                let buckets: Vec<Vec<f32>> = (0..count).map(|_| plane()).collect();
                let ranks = Ranks { radius, share };
                let (found, expected) = (high_ranks(size, &buckets, ranks).unwrap(), by_sorting(size, &buckets, ranks));
                assert_eq!(found.around, expected.around, "{count} buckets, {radius}, {share}, {size}");
                assert_eq!(found.own, expected.own, "{count} buckets, {size}");
            }
        }
    }

    #[test]
    fn what_lies_deep_is_left_to_others() {
        let size = Size::new(4, 4);
        assert!(high_ranks(size, &vec![vec![1.0; 16]; 8], Ranks { radius: 2, share: 0.5 }).is_none());
    }
}
