//! Distances between the patches of some pixels and those of their windows.

use super::Guide;
use crate::patch_distance::PatchDistance;
use crate::rectangle::Rectangle;

/// Distance of pixels outside the image: no bandwidth makes a weight of it.
const FAR: f32 = 1e9;

/// Distances of one tile's fits; keeps its buffers between tiles.
#[derive(Debug)]
pub struct WindowDistances<'a> {
    guide: Guide<'a>,
    patch: PatchDistance<'a>,
    image: Vec<f32>,
    distances: Vec<f32>,
}

impl<'a> WindowDistances<'a> {
    /// Compares patches of `guide`.
    pub fn new(guide: &Guide<'a>) -> Self {
        let patch = PatchDistance::new(guide.planes, guide.comparison);
        Self { guide: *guide, patch, image: Vec::new(), distances: Vec::new() }
    }

    /// Pixels in a window.
    pub fn window(&self) -> usize {
        (2 * self.guide.radius + 1).pow(2)
    }

    /// The distances of the pixels `fits` of `tile`: for each of them those of its window, row by row.
    #[inline(always)]
    pub fn compute(&mut self, tile: Rectangle, fits: &[[usize; 2]]) -> &[f32] {
        let window = self.window();
        self.distances.clear();
        self.distances.resize(fits.len() * window, FAR);
        for (i, offset) in offsets(self.guide.radius).enumerate() {
            let centres = tile.where_inside(offset, self.guide.planes.size);
            if centres.width() == 0 || centres.height() == 0 {
                continue;
            }
            self.patch.compute(centres, offset, &mut self.image);
            for (fit, [x, y]) in fits.iter().enumerate() {
                if centres.contains(*x, *y) {
                    self.distances[fit * window + i] =
                        self.image[(y - centres.y0) * centres.width() + (x - centres.x0)];
                }
            }
        }
        &self.distances
    }
}

/// Offsets [dx, dy] of a window, row by row.
pub fn offsets(radius: usize) -> impl Iterator<Item = [isize; 2]> {
    let reach = radius as isize;
    (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| [dx, dy]))
}
