//! Distances between the patches of some pixels and those of their windows.

use std::ops::Range;

use pulp::Simd;

use super::fitted::Guides;
use super::pairs::PairImages;
use super::region::Region;
use crate::rectangle::Rectangle;

/// Distance of pixels outside the image: no bandwidth makes a weight of it.
const FAR: f32 = 1e9;

/// Distances of one tile's fits (equation 11), which are few among its pixels: distances of single pixels are summed
/// over patches where a fit is, and nowhere else. A pair of pixels is compared once for both its ends.
#[derive(Debug)]
pub struct WindowDistances<'a> {
    guides: Guides<'a>,
    pairs: PairImages,
    /// Sums over the height of a patch, with a patch's radius of zeros on either side, and over its width too.
    columns: Vec<f32>,
    sums: Vec<f32>,
    distances: Vec<f32>,
}

/// Pixels of one row that carry fits.
struct FitRow<'f> {
    y: usize,
    /// Number of the first one.
    first: usize,
    fits: &'f [[usize; 2]],
}

/// Where one image of pairs belongs.
struct Place {
    /// The pixels whose pairs there are.
    valid: Rectangle,
    /// Number of the picture that was compared, and of the direction.
    picture: usize,
    direction: usize,
    /// What is added to a pixel of `valid` to get the one that carries the fit.
    shift: [isize; 2],
    /// Number in the window.
    number: usize,
}

impl<'a> WindowDistances<'a> {
    /// Compares patches of `guides`.
    pub fn new(guides: &Guides<'a>) -> Self {
        let pairs = PairImages::new(guides);
        Self { guides: *guides, pairs, columns: Vec::new(), sums: Vec::new(), distances: Vec::new() }
    }

    /// The distances of the pixels `fits` of `tile`, given row by row: for each picture, for each of them those of its
    /// window, row by row.
    #[inline(always)]
    pub fn compute<S: Simd>(&mut self, simd: S, tile: Rectangle, fits: &[[usize; 2]]) -> &[f32] {
        let Guides { size, values, variances, radius, comparison } = self.guides;
        let planes: Vec<&[f32]> = variances.iter().chain(values.iter().copied().flatten()).map(Vec::as_slice).collect();
        let region = Region::cut(planes.into_iter(), size, tile, radius + comparison.patch_radius);
        let rows = rows_of(fits);
        let around = tile.grown(comparison.patch_radius, size);
        let reached: Vec<bool> = (around.y0..around.y1)
            .map(|y| rows.iter().any(|row| row.y.abs_diff(y) <= comparison.patch_radius))
            .collect();
        let near = |y: usize| reached.get(y.wrapping_sub(around.y0)).is_some_and(|reached| *reached);
        self.distances.clear();
        self.distances.resize(values.len() * fits.len() * self.guides.window(), FAR);
        // The second half of the window's offsets; the first is their mirror image.
        for (i, offset) in offsets(radius).enumerate().skip(self.guides.window() / 2) {
            let valid = both_ways(around, offset).where_inside(offset, size);
            if valid.width() == 0 || valid.height() == 0 {
                continue;
            }
            let needed = |y: usize| near(y) || near(y.wrapping_add_signed(offset[1]));
            self.pairs.compare(simd, &self.guides, &region, valid, offset, needed);
            for picture in 0..values.len() {
                let forward = Place { valid, picture, direction: 0, shift: [0, 0], number: i };
                let back = Place { direction: 1, shift: offset, number: self.guides.window() - 1 - i, ..forward };
                for row in &rows {
                    self.sum_patches(row, &forward, fits.len());
                    if offset != [0, 0] {
                        self.sum_patches(row, &back, fits.len());
                    }
                }
            }
        }
        &self.distances
    }

    /// Means over the patches of all fits of a row, as far as both pixels of a pair lie inside the image.
    #[inline(always)]
    fn sum_patches(&mut self, row: &FitRow, place: &Place, fits: usize) {
        let Place { valid, picture, direction, shift: [dx, dy], number } = *place;
        let Some(centre) = row.y.checked_add_signed(-dy).filter(|y| (valid.y0..valid.y1).contains(y)) else { return };
        let rows = self.reach(centre, valid.y0..valid.y1);
        self.sum_rows(rows.start - valid.y0..rows.end - valid.y0, valid.width(), picture, direction);
        let scale = 1.0 / (rows.len() * self.guides.variances.len()) as f32;
        let whole = scale / (2 * self.guides.comparison.patch_radius + 1) as f32;
        let window = self.guides.window();
        let first = (picture * fits + row.first) * window + number;
        let (radius, width) = (self.guides.comparison.patch_radius, valid.width());
        for (fit, [x, _]) in row.fits.iter().enumerate() {
            // Far beyond the width where it lies to the left.
            let column = x.wrapping_add_signed(-dx).wrapping_sub(valid.x0);
            if column >= width {
                continue;
            }
            let is_whole = column >= radius && column + radius < width;
            let scale = if is_whole { whole } else { scale / self.reach(column, 0..width).len() as f32 };
            self.distances[first + fit * window] = (self.sums[column] * scale).max(0.0);
        }
    }

    /// Sums over patches as wide as `rows` are high, for all `width` columns.
    #[inline(always)]
    fn sum_rows(&mut self, rows: Range<usize>, width: usize, picture: usize, direction: usize) {
        let radius = self.guides.comparison.patch_radius;
        let (image, pitch) = (self.pairs.image(picture, direction), self.pairs.pitch);
        self.columns.clear();
        self.columns.resize(width + 2 * radius, 0.0);
        let columns = &mut self.columns[radius..radius + width];
        for row in rows {
            let pixels = &image[row * pitch..][..width];
            for i in 0..width {
                columns[i] += pixels[i];
            }
        }
        self.sums.clear();
        self.sums.extend_from_slice(&self.columns[..width]);
        for shift in 1..=2 * radius {
            let (sums, columns) = (&mut self.sums[..width], &self.columns[shift..shift + width]);
            for i in 0..width {
                sums[i] += columns[i];
            }
        }
    }

    /// Rows (or columns) of the patch around `centre` that lie in `within`.
    #[inline(always)]
    fn reach(&self, centre: usize, within: Range<usize>) -> Range<usize> {
        let radius = self.guides.comparison.patch_radius;
        centre.saturating_sub(radius).max(within.start)..(centre + radius + 1).min(within.end)
    }
}

/// The pixels of `around`, and those from which the offset leads into it.
fn both_ways(around: Rectangle, [dx, dy]: [isize; 2]) -> Rectangle {
    let low = |start: usize, d: isize| start.min(start.saturating_add_signed(-d));
    let high = |end: usize, d: isize| end.max(end.saturating_add_signed(-d));
    Rectangle { x0: low(around.x0, dx), y0: low(around.y0, dy), x1: high(around.x1, dx), y1: high(around.y1, dy) }
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
