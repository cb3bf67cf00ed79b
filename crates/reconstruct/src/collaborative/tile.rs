//! All fits of one tile.

use pulp::{Simd, WithSimd};
use stack::Size;

use super::distances::{WindowDistances, offsets};
use super::fitted::{Fitted, Guides, Kernel};
use super::moments::moments;
use super::plane::Plane;
use super::region::Region;
use super::row::{FEATURES, RESPONSES};
use super::sums::Sums;
use super::window::{Window, weigh};
use crate::rectangle::Rectangle;

/// Which guide's weights with which kernel: one set of predictions.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Number of the guide.
    pub guide: usize,
    /// The kernel.
    pub kernel: Kernel,
}

/// Fits every pixel of `tile` that some candidate wants: for each candidate, the predictions added up, in the tile and
/// a window's radius around it. Nothing when no pixel is wanted.
pub fn fit_tile(
    fitted: &Fitted,
    guides: &Guides,
    candidates: &[Candidate],
    tile: Rectangle,
    wants: impl Fn(usize, usize, usize) -> bool,
) -> Vec<Sums> {
    let pixels = (tile.y0..tile.y1).flat_map(|y| (tile.x0..tile.x1).map(move |x| [x, y]));
    let fits: Vec<[usize; 2]> =
        pixels.filter(|[x, y]| (0..candidates.len()).any(|candidate| wants(candidate, *x, *y))).collect();
    if fits.is_empty() {
        return Vec::new();
    }
    pulp::Arch::new().dispatch(TileTask { fitted, guides, candidates, tile, fits: &fits, wants })
}

struct TileTask<'a, W> {
    fitted: &'a Fitted<'a>,
    guides: &'a Guides<'a>,
    candidates: &'a [Candidate],
    tile: Rectangle,
    fits: &'a [[usize; 2]],
    wants: W,
}

/// Buffers of one tile.
struct Work {
    region: Region,
    window: Window,
    /// Weights of predictions, and of residuals.
    kernel: Vec<f32>,
    weights: Vec<f32>,
    predictions: Vec<f32>,
}

impl<W: Fn(usize, usize, usize) -> bool> WithSimd for TileTask<'_, W> {
    type Output = Vec<Sums>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut distances = WindowDistances::new(self.guides);
        let distances = distances.compute(simd, self.tile, self.fits);
        let mut work = self.work();
        let falloffs: Vec<Vec<f32>> =
            self.candidates.iter().map(|candidate| falloff(candidate.kernel.sigma, self.guides.radius)).collect();
        let mut sums: Vec<Sums> = self.candidates.iter().map(|candidate| self.zeros(candidate.guide)).collect();
        let (count, window) = (self.fits.len(), self.guides.window());
        for (fit, [x, y]) in self.fits.iter().enumerate() {
            work.window.fetch(&work.region, [*x, *y], self.fitted.features.len(), self.responses(), self.is_weighed());
            for (number, candidate) in self.candidates.iter().enumerate() {
                if (self.wants)(number, *x, *y) {
                    let distances = &distances[(candidate.guide * count + fit) * window..][..window];
                    let scale = 1.0 / (candidate.kernel.bandwidth * candidate.kernel.bandwidth);
                    weigh(distances, scale, &falloffs[number], &mut work.kernel);
                    self.fit(simd, [*x, *y], candidate.guide, &mut work, &mut sums[number]);
                }
            }
        }
        sums
    }
}

impl<W> TileTask<'_, W> {
    fn responses(&self) -> usize {
        self.fitted.responses.iter().map(|responses| responses.len()).sum()
    }

    fn is_weighed(&self) -> bool {
        self.fitted.importance.is_some()
    }

    /// Buffers, and what the tile's windows hold.
    fn work(&self) -> Work {
        let Fitted { features, responses, noise, importance, .. } = *self.fitted;
        let responses = responses.iter().copied().flatten().copied();
        let planes: Vec<&[f32]> =
            features.iter().map(Vec::as_slice).chain(responses).chain([noise]).chain(importance).collect();
        let region = Region::cut(planes.into_iter(), self.guides.size, self.tile, self.guides.radius);
        let window = Window::new(self.guides.side());
        let length = window.length();
        let [kernel, weights] = [(); 2].map(|()| vec![0.0; length]);
        Work { region, window, kernel, weights, predictions: vec![0.0; RESPONSES * length] }
    }

    fn zeros(&self, guide: usize) -> Sums {
        let [width, height] = [self.tile.width(), self.tile.height()].map(|side| side + 2 * self.guides.radius);
        Sums::zeros(Size::new(width, height), self.fitted.responses[guide].len())
    }

    /// One fit with the weights of `work`, and its predictions added to `sums`.
    #[inline(always)]
    fn fit<S: Simd>(&self, simd: S, [x, y]: [usize; 2], guide: usize, work: &mut Work, sums: &mut Sums) {
        let Fitted { features, responses, ridge, .. } = *self.fitted;
        let Work { region, window, kernel, weights, predictions } = work;
        let before: usize = responses[..guide].iter().map(|responses| responses.len()).sum();
        let count = responses[guide].len();
        let mut columns: [&[f32]; FEATURES + RESPONSES] = [&[]; _];
        let mut centre = [0.0; RESPONSES];
        for j in 0..FEATURES {
            columns[j] = window.column(j);
        }
        for c in 0..count {
            columns[FEATURES + c] = window.column(FEATURES + before + c);
            centre[c] = region.from(region.index(features.len() + before + c, x, y))[0];
        }
        window.weigh_residuals(kernel, weights);
        let moments = moments(simd, &columns[..FEATURES + count], weights);
        let weight = moments.weight.max(1e-20);
        let lambda = ridge.least + ridge.per_noise * window.noise(kernel) / (weight * weight);
        let plane = Plane::fitted(simd, &moments, lambda, &centre[..count]);
        plane.predict(simd, &columns, kernel, count, predictions);
        let first = region.window_index(0, [x, y]);
        sums.add_window(first, self.guides.side(), predictions, kernel);
    }
}

/// d²/(2σ²) of every offset of a window.
fn falloff(sigma: f32, radius: usize) -> Vec<f32> {
    offsets(radius).map(|[dx, dy]| (dx * dx + dy * dy) as f32 / (2.0 * sigma * sigma)).collect()
}

#[cfg(test)]
mod tests;
