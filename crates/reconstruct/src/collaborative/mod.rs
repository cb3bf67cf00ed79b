//! Collaborative local regression: every fit predicts its whole window, and predictions are averaged by weight.
//!
//! Weights come from distances between patches of a guide, as in Bitterli et al. 2016, section 5. Because neighbouring
//! fits predict the same pixels, only some pixels need to carry one: those of a lattice, and whatever the lattice leaves
//! uncovered.

mod distances;
mod fitted;
mod moments;
mod plane;
mod row;
mod sums;
#[cfg(test)]
mod test_problem;
mod tile;
#[cfg(test)]
mod twin;
mod window;

use rayon::prelude::*;
use stack::{Cancelled, Image, Monitor, Size};

use crate::rectangle::{Rectangle, tiles_of};
pub use distances::{WindowDistances, offsets};
pub use fitted::{Fitted, Guide, Kernel, Ridge};
pub use row::{FEATURES, Row, rows_of};
use sums::Sums;
use tile::fit_tile;

/// Fits along a side of the tiles that are worked on one by one.
const FITS: usize = 16;

/// Side of the tiles in which single pixels get fits of their own.
const SMALL_TILE: usize = 16;

/// Tiles whose sums are held before they are added to the picture, in order.
const WAVE: usize = 64;

/// A pixel on which fits weigh less than one at the pixel itself would gets a fit of its own.
const COVERED: f32 = 1.0;

/// Predicts both halves of every pixel once per kernel. Reports one unit per tile.
///
/// # Errors
/// When `monitor` cancels.
pub fn collaborate(
    fitted: &Fitted,
    guide: &Guide,
    kernels: &[Kernel],
    monitor: &dyn Monitor,
) -> Result<Vec<[Image; 2]>, Cancelled> {
    let size = guide.planes.size;
    let mut sums: Vec<Sums> = kernels.iter().map(|_| Sums::zeros(size)).collect();
    let stride = fitted.stride;
    let on_lattice = |x: usize, y: usize| x % stride == stride / 2 && y % stride == stride / 2;
    let tiles = tiles_of(size, FITS * stride);
    sweep(fitted, guide, kernels, &mut sums, &tiles, |_, x, y| on_lattice(x, y), monitor)?;
    if stride > 1 {
        let bare: Vec<Vec<bool>> = sums.iter().map(|sums| sums.lighter_than(COVERED)).collect();
        let is_bare = |kernel: usize, x: usize, y: usize| bare[kernel][size.index(x, y)];
        sweep(fitted, guide, kernels, &mut sums, &tiles_of(size, SMALL_TILE), is_bare, monitor)?;
    }
    Ok(sums.into_iter().map(Sums::into_halves).collect())
}

/// How many units [`collaborate`] reports.
pub fn units(size: Size, stride: usize) -> u64 {
    let tiles = |side: usize| tiles_of(size, side).len() as u64;
    tiles(FITS * stride) + if stride > 1 { tiles(SMALL_TILE) } else { 0 }
}

/// Adds the fits at the pixels that each kernel wants.
fn sweep(
    fitted: &Fitted,
    guide: &Guide,
    kernels: &[Kernel],
    sums: &mut [Sums],
    tiles: &[Rectangle],
    wants: impl Fn(usize, usize, usize) -> bool + Sync,
    monitor: &dyn Monitor,
) -> Result<(), Cancelled> {
    for wave in tiles.chunks(WAVE) {
        let parts: Vec<Vec<(Rectangle, Sums)>> = wave
            .par_iter()
            .map(|tile| {
                if monitor.cancelled() {
                    return Err(Cancelled);
                }
                let parts = fit_tile(fitted, guide, kernels, *tile, &wants);
                monitor.advance(1);
                Ok(parts)
            })
            .collect::<Result<_, _>>()?;
        sums.par_iter_mut().enumerate().for_each(|(kernel, sums)| {
            parts.iter().filter_map(|part| part.get(kernel)).for_each(|(place, part)| sums.add(*place, part));
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
