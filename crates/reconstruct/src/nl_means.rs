//! Non-local means: every pixel becomes the average of those whose patches resemble its own (Rousselle et al. 2012,
//! section 4).

use stack::{Cancelled, Monitor, Size};

use crate::exp::exp_of_negative;
use crate::patch_distance::{NoisyPlanes, PatchComparison, PatchDistance};
use crate::pieces::of_each;
use crate::rectangle::{Rectangle, put_together, tiles_of};

/// Side of the tiles that are filtered one by one.
const TILE: usize = 64;

/// What tells which pixels resemble each other.
#[derive(Clone, Copy, Debug)]
pub struct Guide<'a> {
    /// The planes that are compared.
    pub planes: NoisyPlanes<'a>,
    /// How their patches are compared.
    pub comparison: PatchComparison,
    /// Radius of the window, in pixels.
    pub radius: usize,
}

/// How many units [`nl_means`] reports.
pub fn units(size: Size) -> u64 {
    tiles_of(size, TILE).len() as u64
}

/// Averages of `sources` (planes of the guide's size, finite) with the weights exp(−D/k²) of `guide`, D the distance of
/// patches and k the `bandwidth`. Reports one unit per tile.
///
/// # Errors
/// When `monitor` cancels.
pub fn nl_means(
    guide: &Guide,
    bandwidth: f32,
    sources: &[Vec<f32>],
    monitor: &dyn Monitor,
) -> Result<Vec<Vec<f32>>, Cancelled> {
    let size = guide.planes.size;
    let tiles = tiles_of(size, TILE);
    let filtered = of_each(&tiles, monitor, |tile| {
        pulp::Arch::new().dispatch(TileTask { guide, bandwidth, sources, tile: *tile })
    })?;
    Ok(put_together(size, &tiles, &filtered, sources.len()))
}

struct TileTask<'a> {
    guide: &'a Guide<'a>,
    bandwidth: f32,
    sources: &'a [Vec<f32>],
    tile: Rectangle,
}

impl pulp::NullaryFnOnce for TileTask<'_> {
    /// Weighted means, one plane of the tile's size per source.
    type Output = Vec<Vec<f32>>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let pixels = self.tile.width() * self.tile.height();
        let mut patch = PatchDistance::new(self.guide.planes, self.guide.comparison);
        let mut distances = Vec::new();
        let mut weights = vec![0.0; pixels];
        let mut sums = vec![vec![0.0; pixels]; self.sources.len()];
        for offset in crate::collaborative::offsets(self.guide.radius) {
            let centres = self.tile.where_inside(offset, self.guide.planes.size);
            if centres.width() == 0 || centres.height() == 0 {
                continue;
            }
            patch.compute(centres, offset, &mut distances);
            let scale = 1.0 / (self.bandwidth * self.bandwidth);
            distances.iter_mut().for_each(|d| *d = exp_of_negative(-(*d * scale)));
            self.add(centres, offset, &distances, &mut weights, &mut sums);
        }
        for sums in &mut sums {
            sums.iter_mut().zip(&weights).for_each(|(sum, weight)| *sum /= weight);
        }
        sums
    }
}

impl TileTask<'_> {
    #[inline(always)]
    fn add(
        &self,
        centres: Rectangle,
        [dx, dy]: [isize; 2],
        kernel: &[f32],
        weights: &mut [f32],
        sums: &mut [Vec<f32>],
    ) {
        let (width, columns) = (self.guide.planes.size.width, centres.width());
        for (y, kernel) in (centres.y0..centres.y1).zip(kernel.chunks_exact(columns)) {
            let local = (y - self.tile.y0) * self.tile.width() + (centres.x0 - self.tile.x0);
            let there = (y * width + centres.x0).wrapping_add_signed(dx + dy * width as isize);
            weights[local..][..columns].iter_mut().zip(kernel).for_each(|(sum, k)| *sum += k);
            for (sums, source) in sums.iter_mut().zip(self.sources) {
                let values = &source[there..][..columns];
                for ((sum, k), value) in sums[local..][..columns].iter_mut().zip(kernel).zip(values) {
                    *sum += k * value;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
