//! Filtering by groups of alike patches (BM3D; Dabov et al. 2007): what many patches of a picture have in common is
//! kept, what each has alone is noise. It needs neither features nor buckets.
//!
//! Patches that resemble one are stacked and transformed, by a cosine transform of each and a Haar transform along the
//! stack (`group`). The first sweep sets small coefficients to zero; the second finds patches in the first one's picture
//! and shrinks coefficients as that picture's power over the noise's says (Wiener). Every patch of a group is put back,
//! and what overlaps is averaged by how little noise is left in it.

mod group;
mod matching;

use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use stack::Size;

use crate::marks::grown;
use group::{Group, PATCH, Patch};
use matching::{Corner, alike};

/// Pixels from one group's first patch to the next one's.
const STEP: usize = 4;

/// Patches of a group are at most this far from its first, in rows and in columns.
const REACH: usize = 12;

/// Coefficients below this multiple of the noise are dropped.
const THRESHOLD: f32 = 2.7;

/// Most patches of a group of the first sweep: a power of two, for the Haar transform.
const FIRST_GROUP: usize = 16;

/// The same in the second.
const SECOND_GROUP: usize = 32;

/// Rows of groups per thread whose sums are held before they are added to the picture, in order.
const WAVE: usize = 4;

/// `noisy` planes, finite, with white noise of variance 1 each, without most of it, at least where they are `wanted`. Patches
/// are compared in the first plane. `None` where the picture is smaller than a patch.
pub fn block_matched(noisy: &[Vec<f32>], wanted: &[bool], size: Size) -> Option<Vec<Vec<f32>>> {
    if size.width.min(size.height) < PATCH {
        return None;
    }
    // The second sweep looks at patches that hold no pixel that is wanted.
    let around = grown(wanted, size, REACH + PATCH);
    let first = Sweep { size, noisy, wanted: &around, pilot: None }.run();
    Some(Sweep { size, noisy, wanted, pilot: Some(&first) }.run())
}

/// Once over the picture.
#[derive(Clone, Copy, Debug)]
struct Sweep<'a> {
    size: Size,
    noisy: &'a [Vec<f32>],
    /// Pixels that groups are made for; others may stay as they are.
    wanted: &'a [bool],
    /// What tells the power of the picture, if anything does.
    pilot: Option<&'a [Vec<f32>]>,
}

impl Sweep<'_> {
    fn run(&self) -> Vec<Vec<f32>> {
        let mut sums = vec![vec![[0.0_f32; 2]; self.size.pixels()]; self.noisy.len()];
        let rows = corners(self.size.height);
        for wave in rows.chunks(WAVE * rayon::current_num_threads()) {
            let bands: Vec<Band> =
                wave.par_iter().map(|y| pulp::Arch::new().dispatch(Row { sweep: self, y: *y })).collect();
            for band in bands {
                let first = band.top * self.size.width;
                for (sums, band) in sums.iter_mut().zip(band.sums) {
                    for (sum, part) in sums[first..].iter_mut().zip(band) {
                        *sum = [sum[0] + part[0], sum[1] + part[1]];
                    }
                }
            }
        }
        let mean = |([sum, weight], noisy): ([f32; 2], &f32)| if weight > 0.0 { sum / weight } else { *noisy };
        sums.into_iter().zip(self.noisy).map(|(sums, noisy)| sums.into_iter().zip(noisy).map(mean).collect()).collect()
    }

    /// What the groups of the patches with their upper border in row `y` add.
    #[inline(always)]
    fn band<S: Simd>(&self, simd: S, y: usize) -> Band {
        let (size, compared) = (self.size, &self.pilot.unwrap_or(self.noisy)[0]);
        let most = if self.pilot.is_some() { SECOND_GROUP } else { FIRST_GROUP };
        let top = y.saturating_sub(REACH);
        let rows = (y + REACH + PATCH).min(size.height) - top;
        let mut sums = vec![vec![[0.0; 2]; rows * size.width]; self.noisy.len()];
        for x in corners(size.width) {
            let own = Corner { x, y };
            if !own.holds_any(self.wanted, size) {
                continue;
            }
            let found = alike(compared, size, own, REACH, most);
            for (plane, sums) in sums.iter_mut().enumerate() {
                let (patches, weight) = self.shrunk(simd, plane, &found);
                for (corner, patch) in found.iter().zip(patches) {
                    let first = (corner.y - top) * size.width + corner.x;
                    add_patch(&patch, weight, &mut sums[first..], size.width);
                }
            }
        }
        Band { top, sums }
    }

    /// The patches of `plane` at the `found` corners after shrinkage, and the weight of each.
    #[inline(always)]
    fn shrunk<S: Simd>(&self, simd: S, plane: usize, found: &[Corner]) -> (Vec<Patch>, f32) {
        let mut group = Group::new(simd, patches_at(found, &self.noisy[plane], self.size));
        let noise_left = match self.pilot {
            None => group.drop_below(THRESHOLD),
            Some(pilot) => group.shrink_like(&Group::new(simd, patches_at(found, &pilot[plane], self.size))),
        };
        (group.into_patches(simd), 1.0 / noise_left)
    }
}

#[inline(always)]
fn patches_at(corners: &[Corner], plane: &[f32], size: Size) -> Vec<Patch> {
    let mut patches = Vec::with_capacity(corners.len());
    for corner in corners {
        patches.push(corner.patch(plane, size));
    }
    patches
}

/// The groups of one row.
struct Row<'a> {
    sweep: &'a Sweep<'a>,
    y: usize,
}

impl WithSimd for Row<'_> {
    type Output = Band;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Band {
        self.sweep.band(simd, self.y)
    }
}

/// Weighted sums and weights of rows `top` and below, for each plane.
struct Band {
    top: usize,
    sums: Vec<Vec<[f32; 2]>>,
}

/// Adds `patch` to `sums`, which begin at its upper left pixel and have `width` columns.
#[inline(always)]
fn add_patch(patch: &Patch, weight: f32, sums: &mut [[f32; 2]], width: usize) {
    for (sums, values) in sums.chunks_mut(width).zip(patch) {
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum = [sum[0] + weight * value, sum[1] + weight];
        }
    }
}

/// First rows (or columns) of the groups' first patches, so that they cover `length` pixels.
fn corners(length: usize) -> Vec<usize> {
    let last = length - PATCH;
    (0..last).step_by(STEP).chain([last]).collect()
}

#[cfg(test)]
mod tests;
