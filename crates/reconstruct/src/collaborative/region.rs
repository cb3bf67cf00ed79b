//! Planes around one tile, close together in memory.

use stack::Size;

use crate::eight::LANES;
use crate::rectangle::Rectangle;

/// Copies of some planes within a margin around a tile; zeros where that lies outside the image. Reading up to seven
/// numbers past the end of a row is allowed.
#[derive(Debug)]
pub struct Region {
    corner: [usize; 2],
    margin: usize,
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl Region {
    /// Cuts `planes`, each of an image of `size`.
    pub fn cut<'p>(
        planes: impl ExactSizeIterator<Item = &'p [f32]>,
        size: Size,
        tile: Rectangle,
        margin: usize,
    ) -> Self {
        let (width, height) = (tile.width() + 2 * margin, tile.height() + 2 * margin);
        let values = vec![0.0; planes.len() * width * height + LANES];
        let mut region = Self { corner: [tile.x0, tile.y0], margin, width, height, values };
        let inside = tile.grown(margin, size);
        for (number, plane) in planes.enumerate() {
            for y in inside.y0..inside.y1 {
                let to = region.index(number, inside.x0, y);
                let from = size.index(inside.x0, y);
                region.values[to..to + inside.width()].copy_from_slice(&plane[from..from + inside.width()]);
            }
        }
        region
    }

    /// Values from one row to the next.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Where the pixel in column `x`, row `y` of the image lies in plane `number`.
    #[inline(always)]
    pub fn index(&self, number: usize, x: usize, y: usize) -> usize {
        let [x0, y0] = self.corner;
        (number * self.height + y + self.margin - y0) * self.width + x + self.margin - x0
    }

    /// Where the window of a pixel begins in plane `number`, if the margin is the window's radius.
    #[inline(always)]
    pub fn window_index(&self, number: usize, [x, y]: [usize; 2]) -> usize {
        let [x0, y0] = self.corner;
        (number * self.height + y - y0) * self.width + x - x0
    }

    /// All values from `index` on.
    #[inline(always)]
    pub fn from(&self, index: usize) -> &[f32] {
        &self.values[index..]
    }
}
