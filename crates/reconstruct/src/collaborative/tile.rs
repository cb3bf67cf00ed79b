//! All fits of one tile.

use super::distances::{WindowDistances, offsets};
use super::moments::{Neighbour, moments};
use super::plane::Plane;
use super::sums::Sums;
use super::{Fitted, Guide, Kernel};
use crate::exp::exp_of_negative;
use crate::rectangle::Rectangle;
use stack::Size;

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
    pulp::Arch::new().dispatch(TileTask { fitted, guide, kernels, tile, fits: &fits, wants })
}

struct TileTask<'a, W> {
    fitted: &'a Fitted<'a>,
    guide: &'a Guide<'a>,
    kernels: &'a [Kernel],
    tile: Rectangle,
    fits: &'a [[usize; 2]],
    wants: W,
}

impl<W: Fn(usize, usize, usize) -> bool> pulp::NullaryFnOnce for TileTask<'_, W> {
    type Output = Vec<(Rectangle, Sums)>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let mut distances = WindowDistances::new(self.guide);
        let window = distances.window();
        let distances = distances.compute(self.tile, self.fits);
        let place = self.tile.grown(self.guide.radius, self.guide.planes.size);
        let mut weights = vec![0.0; window];
        let mut neighbours = Vec::with_capacity(window);
        let mut parts = Vec::with_capacity(self.kernels.len());
        for (number, kernel) in self.kernels.iter().enumerate() {
            let mut sums = Sums::zeros(Size::new(place.width(), place.height()));
            let falloff = falloff(kernel.sigma, self.guide.radius);
            for (fit, at) in self.fits.iter().enumerate().filter(|(_, [x, y])| (self.wants)(number, *x, *y)) {
                weigh(&distances[fit * window..][..window], kernel.bandwidth, &falloff, &mut weights);
                self.neighbours(*at, place, &weights, &mut neighbours);
                self.fit(*at, &neighbours, &mut sums);
            }
            parts.push((place, sums));
        }
        parts
    }
}

impl<W> TileTask<'_, W> {
    /// The pixels of the window whose weight counts.
    #[inline(always)]
    fn neighbours(&self, [x, y]: [usize; 2], place: Rectangle, weights: &[f32], neighbours: &mut Vec<Neighbour>) {
        let size = self.guide.planes.size;
        let centre = size.index(x, y) as isize;
        let centre_place = ((y - place.y0) * place.width() + (x - place.x0)) as isize;
        let own = self.fitted.importance.map_or(1.0, |importance| 1.0 / importance[centre as usize]);
        neighbours.clear();
        for (offset, kernel) in offsets(self.guide.radius).zip(weights) {
            if *kernel >= NEGLIGIBLE {
                let pixel = (centre + offset[0] + offset[1] * size.width as isize) as usize;
                let weight = self.fitted.importance.map_or(*kernel, |importance| kernel * importance[pixel] * own);
                let place = (centre_place + offset[0] + offset[1] * place.width() as isize) as u32;
                neighbours.push(Neighbour { pixel: pixel as u32, place, kernel: *kernel, weight });
            }
        }
    }

    /// One fit, and its predictions added to `sums`.
    #[inline(always)]
    fn fit(&self, [x, y]: [usize; 2], neighbours: &[Neighbour], sums: &mut Sums) {
        let Fitted { rows, noise, ridge, .. } = *self.fitted;
        let width = self.guide.planes.size.width;
        let centre = &rows[y * width + x];
        let moments = moments(rows, centre, neighbours);
        let noise: f32 = neighbours.iter().map(|n| n.kernel * n.kernel * noise[n.pixel as usize]).sum();
        let weight = moments.weight.max(1e-20);
        let plane = Plane::fitted(&moments, ridge.least + ridge.per_noise * noise / (weight * weight), centre);
        for neighbour in neighbours {
            let prediction = plane.at(&rows[neighbour.pixel as usize], centre);
            let sum = sums.at_mut(neighbour.place as usize);
            for (sum, value) in sum.iter_mut().zip(prediction) {
                *sum = neighbour.kernel.mul_add(value, *sum);
            }
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
