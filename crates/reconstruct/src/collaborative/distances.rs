//! Distances between the patches of some pixels and those of their windows.

use std::ops::Range;

use super::fitted::Guide;
use crate::patch_distance::pixel_distances;
use crate::rectangle::Rectangle;

/// Distance of pixels outside the image: no bandwidth makes a weight of it.
const FAR: f32 = 1e9;

/// Distances of one tile's fits (equation 11), which are few among its pixels: distances of single pixels are summed
/// over patches where a fit is, and nowhere else.
#[derive(Debug)]
pub struct WindowDistances<'a> {
    guide: Guide<'a>,
    /// Distances of single pixels for one offset, row by row.
    pixels: Vec<f32>,
    /// Their sums over the height of a patch.
    columns: Vec<f32>,
    distances: Vec<f32>,
}

/// Pixels of one row that carry fits.
struct FitRow<'f> {
    y: usize,
    /// Number of the first one.
    first: usize,
    fits: &'f [[usize; 2]],
}

impl<'a> WindowDistances<'a> {
    /// Compares patches of `guide`.
    pub fn new(guide: &Guide<'a>) -> Self {
        Self { guide: *guide, pixels: Vec::new(), columns: Vec::new(), distances: Vec::new() }
    }

    /// Pixels in a window.
    pub fn window(&self) -> usize {
        (2 * self.guide.radius + 1).pow(2)
    }

    /// The distances of the pixels `fits` of `tile`, given row by row: for each of them those of its window, row by row.
    #[inline(always)]
    pub fn compute(&mut self, tile: Rectangle, fits: &[[usize; 2]]) -> &[f32] {
        let size = self.guide.planes.size;
        let rows = rows_of(fits);
        self.distances.clear();
        self.distances.resize(fits.len() * self.window(), FAR);
        for (i, offset) in offsets(self.guide.radius).enumerate() {
            let valid = tile.grown(self.guide.comparison.patch_radius, size).where_inside(offset, size);
            if valid.width() > 0 && valid.height() > 0 {
                self.compare_pixels(valid, offset);
                rows.iter().for_each(|row| self.sum_patches(row, valid, i));
            }
        }
        &self.distances
    }

    /// Distances of the single pixels of `valid` to those `offset` away.
    #[inline(always)]
    fn compare_pixels(&mut self, valid: Rectangle, [dx, dy]: [isize; 2]) {
        let width = self.guide.planes.size.width;
        self.pixels.resize(valid.width() * valid.height(), 0.0);
        for (y, out) in (valid.y0..valid.y1).zip(self.pixels.chunks_exact_mut(valid.width())) {
            let here = y * width + valid.x0;
            let there = here.wrapping_add_signed(dx + dy * width as isize);
            pixel_distances(self.guide.planes, here, there, self.guide.comparison, out);
        }
    }

    /// Means over the patches of all fits of a row, as far as both pixels of a pair lie inside the image; stored as
    /// number `i` of their windows.
    #[inline(always)]
    fn sum_patches(&mut self, row: &FitRow, valid: Rectangle, i: usize) {
        if !(valid.y0..valid.y1).contains(&row.y) {
            return;
        }
        let rows = self.reach(row.y, valid.y0..valid.y1);
        self.columns.clear();
        self.columns.resize(valid.width(), 0.0);
        for y in rows.clone() {
            let pixels = &self.pixels[(y - valid.y0) * valid.width()..][..valid.width()];
            self.columns.iter_mut().zip(pixels).for_each(|(sum, pixel)| *sum += pixel);
        }
        let (window, channels) = (self.window(), self.guide.planes.values.len());
        for (fit, [x, _]) in row.fits.iter().enumerate().filter(|(_, [x, _])| (valid.x0..valid.x1).contains(x)) {
            let columns = self.reach(*x, valid.x0..valid.x1);
            let pairs = (rows.len() * columns.len() * channels) as f32;
            let sum: f32 = self.columns[columns.start - valid.x0..columns.end - valid.x0].iter().sum();
            self.distances[(row.first + fit) * window + i] = (sum / pairs).max(0.0);
        }
    }

    /// Rows (or columns) of the patch around `centre` that lie in `within`.
    #[inline(always)]
    fn reach(&self, centre: usize, within: Range<usize>) -> Range<usize> {
        let radius = self.guide.comparison.patch_radius;
        centre.saturating_sub(radius).max(within.start)..(centre + radius + 1).min(within.end)
    }
}

/// Fits by rows.
fn rows_of(fits: &[[usize; 2]]) -> Vec<FitRow<'_>> {
    let mut first = 0;
    fits.chunk_by(|a, b| a[1] == b[1])
        .map(|fits| {
            let row = FitRow { y: fits[0][1], first, fits };
            first += fits.len();
            row
        })
        .collect()
}

/// Offsets [dx, dy] of a window, row by row.
pub fn offsets(radius: usize) -> impl Iterator<Item = [isize; 2]> {
    let reach = radius as isize;
    (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| [dx, dy]))
}

#[cfg(test)]
mod tests;
