//! Square pieces of the film, and what one pass adds to one of them.

use std::ops::Range;

use stack::Size;

use super::feature_groups;
use super::sample::{FEATURE_CHANNELS, GATHERED, RADIANCE_CHANNELS, SampleRecord};
use crate::gather::{GatherPoint, LeavingLight};

/// Side of a tile, in pixels; those at the right and bottom border are smaller.
const SIDE: usize = 16;

/// A piece of the film.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tile {
    columns: Range<usize>,
    rows: Range<usize>,
    /// Pixels in a row of the whole film window.
    stride: usize,
}

impl Tile {
    /// The tiles that make up a window of `size`, row by row.
    pub fn all(size: Size) -> Vec<Self> {
        let starts = |length: usize| (0..length).step_by(SIDE).map(move |s| s..(s + SIDE).min(length));
        starts(size.height)
            .flat_map(|rows| starts(size.width).map(move |columns| (rows.clone(), columns)))
            .map(|(rows, columns)| Self { columns, rows, stride: size.width })
            .collect()
    }

    /// Column, row and index in the window of every pixel, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = (usize, usize, usize)> + '_ {
        self.rows.clone().flat_map(move |y| self.columns.clone().map(move |x| (x, y, y * self.stride + x)))
    }

    fn len(&self) -> usize {
        self.columns.len() * self.rows.len()
    }
}

/// Sums of the samples one pass took in one tile.
#[derive(Debug)]
pub struct TileSums {
    pub(super) tile: Tile,
    /// Samples taken, per pixel of the tile.
    pub(super) taken: Vec<u32>,
    /// Per bucket, channel by channel over the tile's pixels.
    pub(super) radiance: Vec<Vec<f32>>,
    /// Per group of buckets, likewise.
    pub(super) features: Vec<Vec<f32>>,
    /// Light still to be gathered, in the order of samples.
    to_gather: Vec<ToGather>,
}

/// Light still to be gathered for a sample.
#[derive(Clone, Copy, Debug)]
struct ToGather {
    point: GatherPoint,
    /// Of the tile.
    pixel: u16,
    bucket: u16,
}

const _: () = assert!(SIDE * SIDE <= 1 << 16, "a pixel of a tile has a number of 16 bits");

impl TileSums {
    /// Sums of nothing, with room for so many samples.
    pub fn new(tile: Tile, buckets: u32, samples: usize) -> Self {
        let pixels = tile.len();
        Self {
            tile,
            taken: vec![0; pixels],
            radiance: vec![vec![0.0; RADIANCE_CHANNELS * pixels]; buckets as usize],
            features: vec![vec![0.0; FEATURE_CHANNELS * pixels]; feature_groups(buckets as usize)],
            to_gather: Vec::with_capacity(samples),
        }
    }

    /// Adds a sample that belongs to `bucket` to the `pixel`-th pixel of the tile.
    pub fn add(&mut self, pixel: usize, bucket: u32, record: &SampleRecord) {
        let (pixels, group) = (self.taken.len(), bucket as usize % self.features.len());
        self.taken[pixel] += 1;
        accumulate(&mut self.radiance[bucket as usize], pixel, pixels, &record.radiance_channels());
        accumulate(&mut self.features[group], pixel, pixels, &record.feature_channels());
        let to_gather = record.to_gather.map(|point| ToGather { point, pixel: pixel as u16, bucket: bucket as u16 });
        self.to_gather.extend(to_gather);
    }

    /// Where light is still to be gathered for a group of buckets.
    pub(super) fn points_of(&self, group: usize, groups: usize) -> impl Iterator<Item = GatherPoint> + '_ {
        let is_of_group = move |found: &&ToGather| found.bucket as usize % groups == group;
        self.to_gather.iter().filter(is_of_group).map(|found| found.point)
    }

    /// Adds what leaves the surfaces where light is gathered; `light` knows it for each group of buckets.
    pub(super) fn gather(&mut self, light: &[LeavingLight]) {
        let pixels = self.taken.len();
        for ToGather { point, pixel, bucket } in std::mem::take(&mut self.to_gather) {
            let arriving = light[bucket as usize % light.len()].arriving(&point);
            let sums = &mut self.radiance[bucket as usize][pixels * GATHERED.start..];
            accumulate(sums, pixel as usize, pixels, &arriving.to_array());
        }
    }
}

fn accumulate(sums: &mut [f32], pixel: usize, pixels: usize, values: &[f32]) {
    for (channel, value) in values.iter().enumerate() {
        sums[channel * pixels + pixel] += value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for size in [Size::new(1, 1), Size::new(16, 16), Size::new(37, 50)] {
            let mut seen = vec![0; size.pixels()];
            for tile in Tile::all(size) {
                assert_eq!(tile.pixels().count(), tile.len());
                for (x, y, index) in tile.pixels() {
                    assert_eq!(index, size.index(x, y));
                    seen[index] += 1;
                }
            }
            assert!(seen.iter().all(|n| *n == 1));
        }
    }
}
