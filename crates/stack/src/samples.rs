//! Who got how many samples: counts per pixel, and how they were dealt to independent buckets.

use serde::{Deserialize, Serialize};

/// Samples in one block of consecutive points when several buckets share one low-discrepancy sequence.
const BLOCK: u32 = 4;

/// How a pixel's samples are dealt to buckets.
///
/// Samples of *different* sequences are independent; points of one low-discrepancy sequence are not (they avoid one
/// another), so buckets that share a sequence show too much variance between them. See `docs/method.md`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Dealing {
    /// Our own numbering: sample `i` belongs to one of `sequences` scrambled sequences and one of `buckets` buckets.
    Numbered {
        /// Independently scrambled sequences, at least 1.
        sequences: u32,
        /// Buckets, a multiple of `sequences`.
        buckets: u32,
    },
    /// Another renderer's: every pixel has this many samples in each bucket.
    PerBucket(Vec<u32>),
    /// An adaptive renderer's: samples of every pixel in each bucket, a row-major plane for each.
    PerPixel(Vec<Vec<u32>>),
}

/// Where sample `i` of a pixel belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Which independently scrambled sequence it is taken from.
    pub sequence: u32,
    /// Which point of that sequence it is.
    pub point: u32,
    /// Which bucket it is averaged into.
    pub bucket: u32,
}

impl Dealing {
    /// How many buckets there are.
    pub fn buckets(&self) -> usize {
        match self {
            Self::Numbered { buckets, .. } => *buckets as usize,
            Self::PerBucket(counts) => counts.len(),
            Self::PerPixel(planes) => planes.len(),
        }
    }
}

/// Where sample `index` goes when `sequences` independent sequences fill `buckets` buckets.
///
/// Sequences take turns. Within a sequence, blocks of 4 consecutive points take turns over its own buckets, so that a
/// bucket is a well spread point set of its own.
#[inline]
pub fn place(index: u32, sequences: u32, buckets: u32) -> Place {
    let (sequence, point) = (index % sequences, index / sequences);
    let own = buckets / sequences;
    Place { sequence, point, bucket: sequence + sequences * ((point / BLOCK) % own) }
}

/// Sample counts of every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleCounts {
    /// Number of the first sample (0 unless this is a slice of a larger render).
    pub first: u32,
    /// Samples per pixel, row-major. For a foreign stack that does not say: the number of buckets.
    pub total: Vec<u32>,
    /// How they were dealt.
    pub dealing: Dealing,
}

impl SampleCounts {
    /// Every pixel has `per_bucket[b]` samples in bucket `b`.
    pub fn uniform(pixels: usize, per_bucket: Vec<u32>) -> Self {
        Self { first: 0, total: vec![per_bucket.iter().sum(); pixels], dealing: Dealing::PerBucket(per_bucket) }
    }

    /// Pixel `p` has `planes[b][p]` samples in bucket `b`.
    pub fn per_pixel(planes: Vec<Vec<u32>>) -> Self {
        let pixels = planes.first().map_or(0, Vec::len);
        let total = (0..pixels).map(|pixel| sum_of(&planes, pixel, 0, 1)).collect();
        Self { first: 0, total, dealing: Dealing::PerPixel(planes) }
    }

    /// What they take, in bytes.
    pub fn bytes(&self) -> usize {
        let planes = match &self.dealing {
            Dealing::PerPixel(planes) => &planes[..],
            _ => &[],
        };
        planes.iter().chain([&self.total]).map(|plane| std::mem::size_of_val(&plane[..])).sum()
    }

    /// Samples of `pixel` in group `group` when the buckets are gathered into `groups` groups (bucket `b` goes to
    /// group `b mod groups`): with `groups` = number of buckets a bucket's own count, with 2 a half's.
    pub fn in_group(&self, pixel: usize, group: usize, groups: usize) -> u32 {
        match &self.dealing {
            Dealing::PerPixel(planes) => sum_of(planes, pixel, group, groups),
            _ => self.of_total(self.total[pixel], group, groups).unwrap_or(0),
        }
    }

    /// The same for all pixels, to be looked up.
    pub fn grouped(&self, groups: usize) -> GroupCounts<'_> {
        let most = self.total.iter().copied().max().unwrap_or(0).min(MOST_KNOWN / groups.max(1) as u32);
        let of_total = |total: u32| (0..groups).filter_map(move |group| self.of_total(total, group, groups));
        GroupCounts { counts: self, groups, known: (0..=most).flat_map(of_total).collect() }
    }

    /// Samples in a group of a pixel that has `total`, where these tell.
    fn of_total(&self, total: u32, group: usize, groups: usize) -> Option<u32> {
        match &self.dealing {
            Dealing::PerPixel(_) => None,
            Dealing::PerBucket(counts) => Some(counts.iter().skip(group).step_by(groups).sum()),
            Dealing::Numbered { sequences, buckets } => {
                let upto = |n: u32| -> u32 {
                    (group as u32..*buckets)
                        .step_by(groups)
                        .map(|bucket| numbered_before(n, bucket, *sequences, *buckets))
                        .sum()
                };
                Some(upto(self.first.saturating_add(total)) - upto(self.first))
            }
        }
    }

    /// Whether all pixels have as many samples.
    pub fn is_uniform(&self) -> bool {
        self.total.iter().all(|n| *n == self.total[0])
    }

    /// Mean, least and most samples of a pixel.
    pub fn mean_min_max(&self) -> (f64, u32, u32) {
        let sum: u64 = self.total.iter().map(|&n| u64::from(n)).sum();
        let mean = sum as f64 / self.total.len().max(1) as f64;
        let least = self.total.iter().copied().min().unwrap_or(0);
        (mean, least, self.total.iter().copied().max().unwrap_or(0))
    }
}

/// Samples of `pixel` in those of the buckets' planes that make a group; at most what a number can hold.
fn sum_of(planes: &[Vec<u32>], pixel: usize, group: usize, groups: usize) -> u32 {
    planes.iter().skip(group).step_by(groups).fold(0, |sum, plane| sum.saturating_add(plane[pixel]))
}

/// Counts that are looked up, those of all groups together, where totals tell them; those of other pixels are counted anew.
const MOST_KNOWN: u32 = 1 << 17;

/// Sample counts in groups of buckets: [`SampleCounts::in_group`] for one number of groups, looked up by a pixel's total.
#[derive(Clone, Debug)]
pub struct GroupCounts<'a> {
    counts: &'a SampleCounts,
    groups: usize,
    known: Vec<u32>,
}

impl GroupCounts<'_> {
    /// Samples of `pixel` in `group`.
    #[inline]
    pub fn of(&self, pixel: usize, group: usize) -> u32 {
        let at = self.counts.total[pixel] as usize * self.groups + group;
        self.known.get(at).copied().unwrap_or_else(|| self.counts.in_group(pixel, group, self.groups))
    }
}

/// How many of the samples 0..n fall into `bucket`.
fn numbered_before(n: u32, bucket: u32, sequences: u32, buckets: u32) -> u32 {
    let (sequence, slot, own) = (bucket % sequences, bucket / sequences, buckets / sequences);
    let points = n / sequences + u32::from(sequence < n % sequences);
    let round = BLOCK * own;
    (points / round) * BLOCK + (points % round).saturating_sub(slot * BLOCK).min(BLOCK)
}

/// What the tracer shall do next: for every pixel a range of sample numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SampleMap {
    /// Number of the first sample to take, row-major.
    pub first: Vec<u32>,
    /// How many to take from there.
    pub count: Vec<u32>,
}

impl SampleMap {
    /// The samples `first..first + count` for each of `pixels` pixels.
    pub fn uniform(pixels: usize, first: u32, count: u32) -> Self {
        Self { first: vec![first; pixels], count: vec![count; pixels] }
    }

    /// Samples asked for, all pixels together.
    pub fn samples(&self) -> u64 {
        self.count.iter().map(|&n| u64::from(n)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_agree_with_dealing_sample_by_sample() {
        for (sequences, buckets) in [(1, 1), (1, 8), (2, 8), (8, 8), (2, 2)] {
            for (first, total) in [(0, 1), (0, 4), (0, 13), (0, 100), (7, 40)] {
                let counts =
                    SampleCounts { first, total: vec![total], dealing: Dealing::Numbered { sequences, buckets } };
                let mut expected = vec![0; buckets as usize];
                for i in first..first + total {
                    expected[place(i, sequences, buckets).bucket as usize] += 1;
                }
                for b in 0..buckets as usize {
                    assert_eq!(
                        counts.in_group(0, b, buckets as usize),
                        expected[b],
                        "{sequences} {buckets} {first}+{total}"
                    );
                }
                if buckets > 1 {
                    let even: u32 = expected.iter().step_by(2).sum();
                    assert_eq!(counts.in_group(0, 0, 2), even);
                    assert_eq!(counts.grouped(2).of(0, 0), even);
                    assert_eq!(counts.in_group(0, 1, 2), total - even);
                }
            }
        }
    }

    #[test]
    fn counts_of_their_own_are_gathered_into_groups() {
        let counts = SampleCounts::per_pixel(vec![vec![1, 20_000], vec![2, 0], vec![3, 7], vec![4, 1]]);
        assert_eq!(counts.total, [10, 20_008]);
        for (pixel, halves) in [[4, 6], [20_007, 1]].into_iter().enumerate() {
            for half in 0..2 {
                assert_eq!(counts.in_group(pixel, half, 2), halves[half]);
                assert_eq!(counts.grouped(2).of(pixel, half), halves[half]);
            }
        }
        assert_eq!(counts.bytes(), 5 * 8);
    }

    #[test]
    fn every_point_of_a_sequence_is_used_once_and_in_order() {
        let mut next = [0; 2];
        for i in 0..64 {
            let at = place(i, 2, 8);
            assert_eq!(at.point, next[at.sequence as usize]);
            next[at.sequence as usize] += 1;
        }
    }
}
