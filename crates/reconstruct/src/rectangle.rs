//! Rectangles of an image, and the tiles it is worked on in.

use rayon::prelude::*;
use stack::Size;

/// Columns `x0..x1` and rows `y0..y1` of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rectangle {
    /// First column.
    pub x0: usize,
    /// First row.
    pub y0: usize,
    /// One past the last column.
    pub x1: usize,
    /// One past the last row.
    pub y1: usize,
}

impl Rectangle {
    /// The pixels at most `by` away from the one in column `x`, row `y` in each direction, inside an image of `size`.
    pub fn around([x, y]: [usize; 2], by: usize, size: Size) -> Self {
        Self { x0: x, y0: y, x1: x + 1, y1: y + 1 }.grown(by, size)
    }

    /// Pixels in a row.
    pub fn width(self) -> usize {
        self.x1.saturating_sub(self.x0)
    }

    /// Rows.
    pub fn height(self) -> usize {
        self.y1.saturating_sub(self.y0)
    }

    /// The pixels at most `by` away from this one in each direction, inside an image of `size`.
    pub fn grown(self, by: usize, size: Size) -> Self {
        Self {
            x0: self.x0.saturating_sub(by),
            y0: self.y0.saturating_sub(by),
            x1: (self.x1 + by).min(size.width),
            y1: (self.y1 + by).min(size.height),
        }
    }

    /// Those of its pixels that are still inside an image of `size` when moved by `offset`.
    pub fn where_inside(self, [dx, dy]: [isize; 2], size: Size) -> Self {
        let low = |least: usize, d: isize| least.max((-d).max(0) as usize);
        let high = |most: usize, d: isize, length: usize| most.min(length.saturating_sub(d.max(0) as usize));
        Self {
            x0: low(self.x0, dx),
            y0: low(self.y0, dy),
            x1: high(self.x1, dx, size.width),
            y1: high(self.y1, dy, size.height),
        }
    }
}

/// Squares of `side` pixels that cover an image of `size`, row by row; those at the right and lower border are smaller.
pub fn tiles_of(size: Size, side: usize) -> Vec<Rectangle> {
    let corners = (0..size.height).step_by(side).flat_map(|y| (0..size.width).step_by(side).map(move |x| (x, y)));
    corners
        .map(|(x, y)| Rectangle { x0: x, y0: y, x1: (x + side).min(size.width), y1: (y + side).min(size.height) })
        .collect()
}

/// Tiles made into whole planes.
pub fn put_together(size: Size, tiles: &[Rectangle], parts: &[Vec<Vec<f32>>], planes: usize) -> Vec<Vec<f32>> {
    let whole = |number: usize| {
        let mut plane = vec![0.0; size.pixels()];
        for (tile, planes) in tiles.iter().zip(parts) {
            for (y, row) in (tile.y0..tile.y1).zip(planes[number].chunks_exact(tile.width())) {
                plane[size.index(tile.x0, y)..][..row.len()].copy_from_slice(row);
            }
        }
        plane
    };
    (0..planes).into_par_iter().map(whole).collect()
}

#[cfg(test)]
mod tests;
