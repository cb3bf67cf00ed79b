//! All fits of one tile.

use pulp::{Simd, WithSimd};
use stack::Size;

use super::distances::{WindowDistances, offsets};
use super::fitted::{Fitted, Guide, Kernel};
use super::moments::moments;
use super::plane::Plane;
use super::row::FEATURES;
use super::sums::Sums;
use super::window::Neighbours;
use crate::exp::exp_of_negative;
use crate::rectangle::Rectangle;

/// Pixels of less weight have no say in a fit, nor it in them.
const NEGLIGIBLE: f32 = 1e-4;

/// Fits every pixel of `tile` that some kernel wants: for each kernel, the predictions added up and where they lie.
/// Nothing when no pixel is wanted.
pub fn fit_tile(
    fitted: &Fitted,
    guide: &Guide,
    kernels: &[Kernel],
    tile: Rectangle,
    wants: impl Fn(usize, usize, usize) -> bool,
) -> Vec<(Rectangle, Sums)> {
    let pixels = (tile.y0..tile.y1).flat_map(|y| (tile.x0..tile.x1).map(move |x| [x, y]));
    let fits: Vec<[usize; 2]> =
        pixels.filter(|[x, y]| (0..kernels.len()).any(|kernel| wants(kernel, *x, *y))).collect();
    if fits.is_empty() {
        return Vec::new();
    }
    let place = tile.grown(guide.radius, guide.planes.size);
    pulp::Arch::new().dispatch(TileTask { fitted, guide, kernels, tile, place, fits: &fits, wants })
}

struct TileTask<'a, W> {
    fitted: &'a Fitted<'a>,
    guide: &'a Guide<'a>,
    kernels: &'a [Kernel],
    tile: Rectangle,
    /// Where the predictions lie.
    place: Rectangle,
    fits: &'a [[usize; 2]],
    wants: W,
}

impl<W: Fn(usize, usize, usize) -> bool> WithSimd for TileTask<'_, W> {
    type Output = Vec<(Rectangle, Sums)>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut distances = WindowDistances::new(self.guide);
        let window = distances.window();
        let distances = distances.compute(self.tile, self.fits);
        let (mut weights, mut neighbours) = (vec![0.0; window], Neighbours::default());
        let mut parts = Vec::with_capacity(self.kernels.len());
        for (number, kernel) in self.kernels.iter().enumerate() {
            let mut sums = Sums::zeros(Size::new(self.place.width(), self.place.height()));
            let falloff = falloff(kernel.sigma, self.guide.radius);
            for (fit, [x, y]) in self.fits.iter().enumerate() {
                if (self.wants)(number, *x, *y) {
                    weigh(&distances[fit * window..][..window], kernel.bandwidth, &falloff, &mut weights);
                    self.select([*x, *y], &weights, &mut neighbours);
                    self.fit(simd, [*x, *y], &mut neighbours, &mut sums);
                }
            }
            parts.push((self.place, sums));
        }
        parts
    }
}

impl<W> TileTask<'_, W> {
    /// The pixels of the window whose weight counts.
    #[inline(always)]
    fn select(&self, [x, y]: [usize; 2], weights: &[f32], neighbours: &mut Neighbours) {
        let (radius, size) = (self.guide.radius, self.guide.planes.size);
        let side = 2 * radius + 1;
        neighbours.clear();
        for (j, weights) in weights.chunks_exact(side).enumerate() {
            let Some(row) = (y + j).checked_sub(radius).filter(|row| *row < size.height) else { continue };
            let columns = radius.saturating_sub(x)..side.min(size.width + radius - x);
            let pixel = size.index(x + columns.start - radius, row);
            let place = (row - self.place.y0) * self.place.width() + x + columns.start - radius - self.place.x0;
            for (i, kernel) in weights[columns].iter().enumerate() {
                if *kernel >= NEGLIGIBLE {
                    neighbours.push(pixel + i, place + i, *kernel);
                }
            }
        }
    }

    /// One fit, and its predictions added to `sums`.
    #[inline(always)]
    fn fit<S: Simd>(&self, simd: S, [x, y]: [usize; 2], neighbours: &mut Neighbours, sums: &mut Sums) {
        let Fitted { rows, importance, noise, ridge, .. } = *self.fitted;
        let centre = self.guide.planes.size.index(x, y);
        neighbours.fetch(simd, rows, importance, centre);
        let moments = moments(simd, &neighbours.rows, &neighbours.weights);
        let noise: f32 =
            neighbours.kernel.iter().zip(&neighbours.pixels).map(|(k, pixel)| k * k * noise[*pixel as usize]).sum();
        let weight = moments.weight.max(1e-20);
        let lambda = ridge.least + ridge.per_noise * noise / (weight * weight);
        let plane = Plane::fitted(simd, &moments, lambda, &rows[centre][FEATURES..]);
        for ((row, kernel), place) in neighbours.rows.iter().zip(&neighbours.kernel).zip(&neighbours.places) {
            plane.add_prediction(simd, row, *kernel, sums.at_mut(*place as usize));
        }
    }
}

/// d²/(2σ²) of every offset of a window.
fn falloff(sigma: f32, radius: usize) -> Vec<f32> {
    offsets(radius).map(|[dx, dy]| (dx * dx + dy * dy) as f32 / (2.0 * sigma * sigma)).collect()
}

#[inline(always)]
fn weigh(distances: &[f32], bandwidth: f32, falloff: &[f32], weights: &mut [f32]) {
    let scale = 1.0 / (bandwidth * bandwidth);
    for ((weight, distance), falloff) in weights.iter_mut().zip(distances).zip(falloff) {
        *weight = exp_of_negative(-(distance * scale + falloff));
    }
}

#[cfg(test)]
mod tests;
