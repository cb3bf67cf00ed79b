//! The film: partial means of everything paths record.
//!
//! Its state is what a stack file holds (`f32` means and sample counts), combined once per pass, so that a render that
//! was written, read and continued ends in the same bytes as one that never stopped; but for gathered light, for which it
//! also knows what leaves the surfaces that paths have met.

mod error;
mod sample;
mod stack_form;
mod tile;

pub use error::NotAFilm;
use rayon::prelude::*;
use sample::{FEATURE_CHANNELS, RADIANCE_CHANNELS};
pub use sample::{FeatureRecord, SampleRecord};
use stack::{Dealing, Image, SampleCounts, SampleMap, Size, Window};
pub use tile::{Tile, TileSums};

use crate::gather::LeavingLight;
use crate::integrator::TraceSettings;

/// Partial means of a film window's pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    window: Window,
    size: Size,
    counts: SampleCounts,
    /// One image per bucket, its channels being scattered, emitted, indirect and gathered radiance.
    radiance: Vec<Image>,
    /// One image per group of buckets (even, odd), its channels being those of all features in order.
    features: Vec<Image>,
    /// For each group of features: what leaves the surfaces that its paths went on from the feature hit to.
    leaving: Vec<LeavingLight>,
}

/// Groups that features are kept in: two halves, as far as there are buckets.
const fn feature_groups(buckets: usize) -> usize {
    if buckets < 2 { 1 } else { 2 }
}

impl Film {
    /// An empty film for the part `window` of a picture of `size`, with the buckets that `settings` ask for.
    pub fn new(window: Window, size: Size, settings: &TraceSettings) -> Self {
        let TraceSettings { sequences, buckets, .. } = *settings;
        let groups = feature_groups(buckets as usize);
        Self {
            window,
            size,
            counts: SampleCounts {
                first: 0,
                total: vec![0; window.size.pixels()],
                dealing: Dealing::Numbered { sequences, buckets },
            },
            radiance: vec![Image::zeros(window.size, RADIANCE_CHANNELS); buckets as usize],
            features: vec![Image::zeros(window.size, FEATURE_CHANNELS); groups],
            leaving: no_light(groups),
        }
    }

    /// The same film, empty, for a slice of the render whose first sample has number `first`.
    pub fn starting_at(mut self, first: u32) -> Self {
        self.counts.first = first;
        self
    }

    /// The part of the picture it covers.
    pub const fn window(&self) -> Window {
        self.window
    }

    /// The whole picture's size.
    pub const fn size(&self) -> Size {
        self.size
    }

    /// How many samples it holds.
    pub const fn counts(&self) -> &SampleCounts {
        &self.counts
    }

    /// How many samples it holds, all pixels together.
    pub fn samples(&self) -> u64 {
        self.counts.total.iter().map(|n| u64::from(*n)).sum()
    }

    /// How many samples of all pixels come before the next ones, those of slices before this one included.
    pub(crate) fn samples_before(&self) -> u64 {
        self.counts.total.iter().map(|n| u64::from(self.counts.first) + u64::from(*n)).sum()
    }

    /// The next `count` samples of every pixel.
    pub fn next_samples(&self, count: u32) -> SampleMap {
        let first = self.counts.total.iter().map(|n| self.counts.first + n).collect();
        SampleMap { first, count: vec![count; self.counts.total.len()] }
    }

    /// The next samples of every pixel that has fewer than `count`, so that it has as many.
    pub fn samples_up_to(&self, count: u32) -> SampleMap {
        let missing = self.counts.total.iter().map(|n| count.saturating_sub(*n)).collect();
        SampleMap { count: missing, ..self.next_samples(0) }
    }

    /// Independently scrambled sequences and buckets.
    pub(crate) fn dealing(&self) -> [u32; 2] {
        match self.counts.dealing {
            Dealing::Numbered { sequences, buckets } => [sequences, buckets],
            // A film is made with numbered samples only.
            Dealing::PerBucket(_) | Dealing::PerPixel(_) => [0, 0],
        }
    }

    /// Adds the samples of a whole pass, each pixel's in at most one of `tiles`.
    pub(crate) fn add_pass(&mut self, tiles: &mut [TileSums]) {
        self.gather(tiles);
        let tiles = &*tiles;
        let before = self.counts.clone();
        for sums in tiles {
            for (taken, (_, _, pixel)) in sums.taken.iter().zip(sums.tile.pixels()) {
                self.counts.total[pixel] += taken;
            }
        }
        let counts = [&before, &self.counts];
        let combine_all = |images: &mut [Image], sums: fn(&TileSums) -> &[Vec<f32>]| {
            let groups = images.len();
            images.par_iter_mut().enumerate().for_each(|(group, image)| {
                for tile in tiles {
                    combine(image, tile, &sums(tile)[group], |pixel| {
                        counts.map(|c| c.in_group(pixel, group, groups) as f32)
                    });
                }
            });
        };
        combine_all(&mut self.radiance, |tile| &tile.radiance);
        combine_all(&mut self.features, |tile| &tile.features);
    }

    /// Learns from the paths of a pass what leaves surfaces, and gives it to the same paths.
    fn gather(&mut self, tiles: &mut [TileSums]) {
        let groups = self.leaving.len();
        self.leaving.par_iter_mut().enumerate().for_each(|(group, leaving)| {
            leaving.learn(|| tiles.iter().flat_map(move |sums| sums.points_of(group, groups)));
        });
        tiles.par_iter_mut().for_each(|sums| sums.gather(&self.leaving));
    }
}

/// What leaves surfaces for each of so many `groups` of buckets, before there are paths. It learns on all threads.
fn no_light(groups: usize) -> Vec<LeavingLight> {
    let parts = rayon::current_num_threads().div_ceil(groups.max(1));
    vec![LeavingLight::in_parts(parts); groups]
}

/// Combines means over `counts(pixel)[0]` samples with `sums` to means over `counts(pixel)[1]` samples.
fn combine(image: &mut Image, tile: &TileSums, sums: &[f32], counts: impl Fn(usize) -> [f32; 2]) {
    let pixels = tile.taken.len();
    for (i, (_, _, pixel)) in tile.tile.pixels().enumerate() {
        let [before, after] = counts(pixel);
        if after == before {
            continue;
        }
        for (channel, sums) in image.channels_mut().iter_mut().zip(sums.chunks_exact(pixels)) {
            channel[pixel] = (before * channel[pixel] + sums[i]) / after;
        }
    }
}

#[cfg(test)]
mod tests;
