//! Collaborative local regression: every fit predicts its whole window, and predictions are averaged by weight.
//!
//! Weights come from distances between patches of a guide, as in Bitterli et al. 2016, section 5. Because neighbouring
//! fits predict the same pixels, only some pixels need to carry one: those of a lattice, and whatever the lattice leaves
//! uncovered.

mod distances;
mod fitted;
mod moments;
mod plane;
mod region;
mod row;
mod sums;
#[cfg(test)]
mod test_problem;
mod tile;
#[cfg(test)]
mod twin;
mod window;

use rayon::prelude::*;
use stack::{Cancelled, Monitor, Size};

use crate::pieces::of_each;
use crate::rectangle::{Rectangle, tiles_of};
pub use distances::offsets;
pub use fitted::{Fitted, Guides, Kernel, Ridge};
pub use row::{FEATURES, RESPONSES};
use sums::Sums;
use tile::{Candidate, Fits, fit_tile};

/// Fits along a side of the tiles that are worked on one by one.
const FITS: usize = 16;

/// Side of the tiles in which single pixels get fits of their own.
const SMALL_TILE: usize = 16;

/// Tiles per thread whose sums are held before they are added to the picture, in order.
const WAVE: usize = 4;

/// What is predicted with one kernel: for each guide, one plane per response.
pub type Predicted = Vec<Vec<Vec<f32>>>;

/// Predicts all responses at every pixel, once per kernel. Reports one unit per tile.
///
/// # Errors
/// When `monitor` cancels.
///
/// # Panics
/// When there are more features or responses than fit, or planes differ in size: mistakes in the calling code.
pub fn collaborate(
    fitted: &Fitted,
    guides: &Guides,
    kernels: &[Kernel],
    monitor: &dyn Monitor,
) -> Result<Vec<Predicted>, Cancelled> {
    assert!(fitted.features.len() <= FEATURES, "a fit has at most {FEATURES} features");
    assert!(fitted.responses.iter().map(|r| r.len()).sum::<usize>() <= RESPONSES, "at most {RESPONSES} responses");
    let of_kernel = |kernel: &Kernel| {
        let kernel = *kernel;
        (0..guides.values.len()).map(move |guide| Candidate { guide, kernel })
    };
    let candidates: Vec<Candidate> = kernels.iter().flat_map(of_kernel).collect();
    let work = Sweep { fitted, guides, candidates: &candidates, monitor };
    let mut sums: Vec<Sums> =
        candidates.iter().map(|c| Sums::zeros(guides.size, fitted.responses[c.guide].len())).collect();
    let stride = fitted.stride;
    let on_lattice = |x: usize, y: usize| x % stride == stride / 2 && y % stride == stride / 2;
    work.run(&mut sums, &tiles_of(guides.size, FITS * stride), |_, x, y| on_lattice(x, y))?;
    if stride > 1 {
        // What no fit reaches at all needs one of its own whatever was asked for.
        let least = fitted.covered.max(f32::MIN_POSITIVE);
        let bare: Vec<Vec<bool>> = sums.iter().map(|sums| sums.lighter_than(least)).collect();
        let is_bare = |candidate: usize, x: usize, y: usize| bare[candidate][guides.size.index(x, y)];
        work.run(&mut sums, &tiles_of(guides.size, SMALL_TILE), is_bare)?;
    }
    let mut means = sums.into_iter().map(Sums::into_means);
    Ok(kernels.iter().map(|_| means.by_ref().take(guides.values.len()).collect()).collect())
}

/// Rows after which the pattern of fits and tiles comes round again: an image that is cut there is worked on as if it
/// were whole, but for what its borders reach.
pub const fn period(stride: usize) -> usize {
    const { assert!(FITS.is_multiple_of(SMALL_TILE), "small tiles fill the large ones") };
    FITS * stride
}

/// How many units [`collaborate`] reports.
pub fn units(size: Size, stride: usize) -> u64 {
    let tiles = |side: usize| tiles_of(size, side).len() as u64;
    tiles(FITS * stride) + if stride > 1 { tiles(SMALL_TILE) } else { 0 }
}

/// Everything a sweep over tiles needs.
struct Sweep<'a> {
    fitted: &'a Fitted<'a>,
    guides: &'a Guides<'a>,
    candidates: &'a [Candidate],
    monitor: &'a dyn Monitor,
}

impl Sweep<'_> {
    /// Adds the fits at the pixels that each candidate wants.
    fn run(
        &self,
        sums: &mut [Sums],
        tiles: &[Rectangle],
        wants: impl Fn(usize, usize, usize) -> bool + Sync,
    ) -> Result<(), Cancelled> {
        for wave in tiles.chunks(WAVE * rayon::current_num_threads()) {
            let fits = |tile: &Rectangle| fit_tile(self.fitted, self.guides, self.candidates, *tile, &wants);
            let parts = of_each(wave, self.monitor, fits)?;
            sums.par_iter_mut().enumerate().for_each(|(candidate, sums)| {
                for Fits { tile, sums: parts } in parts.iter().flatten() {
                    sums.add(*tile, self.guides.radius, &parts[candidate]);
                }
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
