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
    planes: usize,
    /// The planes, and one that is 1 inside the image.
    values: Vec<f32>,
}

impl Region {
    /// Cuts `planes`, each of an image of `size`.
    pub fn cut(planes: &[&[f32]], size: Size, tile: Rectangle, margin: usize) -> Self {
        let (width, height) = (tile.width() + 2 * margin, tile.height() + 2 * margin);
        let values = vec![0.0; (planes.len() + 1) * width * height + LANES];
        let corner = [tile.x0, tile.y0];
        let mut region = Self { corner, margin, width, height, planes: planes.len(), values };
        let inside = tile.grown(margin, size);
        for y in inside.y0..inside.y1 {
            let from = size.index(inside.x0, y);
            for (number, plane) in planes.iter().enumerate() {
                let to = region.index(number, inside.x0, y);
                region.values[to..to + inside.width()].copy_from_slice(&plane[from..from + inside.width()]);
            }
            let to = region.inside_index(inside.x0, y);
            region.values[to..to + inside.width()].fill(1.0);
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

    /// Where it stands whether the image has that pixel: 1, else 0.
    #[inline(always)]
    pub fn inside_index(&self, x: usize, y: usize) -> usize {
        self.index(self.planes, x, y)
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
