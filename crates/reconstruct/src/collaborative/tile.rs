//! All fits of one tile.

use pulp::{Simd, WithSimd};
use stack::Size;

use super::distances::{WindowDistances, offsets};
use super::fitted::{Fitted, Guides, Kernel, Ridge};
use super::moments::Products;
use super::plane::Plane;
use super::region::Region;
use super::row::RESPONSES;
use super::sums::Sums;
use super::window::{Layout, Window};
use crate::eight::{LANES, Lanes};
use crate::rectangle::Rectangle;

/// Which guide's weights with which kernel: one set of predictions.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Number of the guide.
    pub guide: usize,
    /// The kernel.
    pub kernel: Kernel,
}

/// What some fits predict.
#[derive(Debug)]
pub struct Fits {
    /// The smallest rectangle that holds them.
    pub tile: Rectangle,
    /// For each candidate, the predictions added up, in `tile` and a window's radius around it.
    pub sums: Vec<Sums>,
}

/// Fits every pixel of `tile` that some candidate wants; nothing when no pixel is wanted.
pub fn fit_tile(
    fitted: &Fitted,
    guides: &Guides,
    candidates: &[Candidate],
    tile: Rectangle,
    wants: impl Fn(usize, usize, usize) -> bool,
) -> Option<Fits> {
    let pixels = (tile.y0..tile.y1).flat_map(|y| (tile.x0..tile.x1).map(move |x| [x, y]));
    let fits: Vec<[usize; 2]> =
        pixels.filter(|[x, y]| (0..candidates.len()).any(|candidate| wants(candidate, *x, *y))).collect();
    if fits.is_empty() {
        return None;
    }
    let tile = around(&fits);
    let sums = pulp::Arch::new().dispatch(TileTask { fitted, guides, candidates, tile, fits: &fits, wants });
    Some(Fits { tile, sums })
}

/// The smallest rectangle that holds all `fits`.
fn around(fits: &[[usize; 2]]) -> Rectangle {
    let [x, y] = [0, 1].map(|axis: usize| {
        let all = fits.iter().map(move |fit| fit[axis]);
        (all.clone().min().unwrap_or(0), all.max().map_or(0, |last| last + 1))
    });
    Rectangle { x0: x.0, y0: y.0, x1: x.1, y1: y.1 }
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
    products: Products,
    predictions: Vec<Lanes>,
}

impl<W: Fn(usize, usize, usize) -> bool> WithSimd for TileTask<'_, W> {
    type Output = Vec<Sums>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let distances = WindowDistances::new(self.guides, self.tile);
        let window = self.guides.side() * self.guides.groups();
        let mut of_guide = vec![vec![[0.0; LANES]; window]; self.guides.values.len()];
        let mut work = self.work();
        let falloffs: Vec<Vec<Lanes>> =
            self.candidates.iter().map(|candidate| falloff(candidate.kernel.sigma, self.guides)).collect();
        let mut sums: Vec<Sums> = self.candidates.iter().map(|candidate| self.zeros(candidate.guide)).collect();
        for [x, y] in self.fits.iter().copied() {
            let wanted = |number: usize| (self.wants)(number, x, y);
            let is_guide =
                |guide: usize| (0..self.candidates.len()).any(|i| self.candidates[i].guide == guide && wanted(i));
            match &mut of_guide[..] {
                [one, two] if is_guide(0) && is_guide(1) => distances.compute(simd, [x, y], [0, 1], [one, two]),
                all => {
                    for (guide, one) in all.iter_mut().enumerate().filter(|(guide, _)| is_guide(*guide)) {
                        distances.compute(simd, [x, y], [guide], [one]);
                    }
                }
            }
            for number in (0..self.candidates.len()).filter(|number| wanted(*number)) {
                let Candidate { guide, kernel } = self.candidates[number];
                work.window.weigh(&of_guide[guide], 1.0 / (kernel.bandwidth * kernel.bandwidth), &falloffs[number]);
                self.fit(simd, [x, y], guide, &mut work, &mut sums[number]);
            }
        }
        sums
    }
}

impl<W> TileTask<'_, W> {
    /// Buffers, and what the tile's windows hold.
    fn work(&self) -> Work {
        let Fitted { features, responses, noise, importance, .. } = *self.fitted;
        let responses = responses.iter().copied().flatten().copied();
        let planes: Vec<&[f32]> =
            features.iter().map(Vec::as_slice).chain(responses).chain([noise]).chain(importance).collect();
        let region = Region::cut(&planes, self.guides.size, self.tile, self.guides.radius);
        let window = Window::new(self.guides, region.width());
        let predictions = vec![[0.0; LANES]; RESPONSES * self.guides.side() * self.guides.groups()];
        Work { region, window, products: Products::new(), predictions }
    }

    /// What the planes of the region are to a fit with the weights of `guide`.
    fn layout(&self, guide: usize) -> Layout {
        let Fitted { features, responses, importance, .. } = *self.fitted;
        let count = |responses: &[&[&[f32]]]| responses.iter().map(|planes| planes.len()).sum::<usize>();
        let first = features.len() + count(&responses[..guide]);
        let noise = features.len() + count(responses);
        let importance = importance.map(|_| noise + 1);
        Layout { features: features.len(), responses: first..first + responses[guide].len(), noise, importance }
    }

    fn zeros(&self, guide: usize) -> Sums {
        let [width, height] = [self.tile.width(), self.tile.height()].map(|side| side + 2 * self.guides.radius);
        Sums::zeros(Size::new(width, height), self.fitted.responses[guide].len())
    }

    /// One fit with the weights of `work`, and its predictions added to `sums`.
    #[inline(always)]
    fn fit<S: Simd>(&self, simd: S, fit: [usize; 2], guide: usize, work: &mut Work, sums: &mut Sums) {
        let Work { region, window, products, predictions } = work;
        let layout = self.layout(guide);
        window.fetch(simd, region, fit, &layout);
        let (columns, features, responses) = (window.columns(), window.features(), layout.responses.len());
        let mut centre = [0.0; RESPONSES];
        for (value, plane) in centre.iter_mut().zip(layout.responses.clone()) {
            *value = region.from(region.index(plane, fit[0], fit[1]))[0];
        }
        let moments = products.moments(simd, &columns[..features + responses], features, window.weights());
        let weight = moments.weight.max(1e-20);
        let Ridge { least, per_noise } = self.fitted.ridge;
        let lambda = least + per_noise * window.noise(simd, region, fit, &layout) / (weight * weight);
        let plane = Plane::fitted(simd, &moments, lambda, &centre[..responses]);
        plane.predict(simd, &columns, window.kernel(), responses, predictions);
        sums.add_groups(simd, region.window_index(0, fit), window.places(), predictions, window.kernel());
    }
}

/// d²/(2σ²) of every offset of a window; what rows are padded with is beyond all reach.
fn falloff(sigma: f32, guides: &Guides) -> Vec<Lanes> {
    let mut falloff = vec![[f32::INFINITY; LANES]; guides.side() * guides.groups()];
    for (i, [dx, dy]) in offsets(guides.radius).enumerate() {
        let (row, column) = (i / guides.side(), i % guides.side());
        falloff[row * guides.groups() + column / LANES][column % LANES] =
            (dx * dx + dy * dy) as f32 / (2.0 * sigma * sigma);
    }
    falloff
}

#[cfg(test)]
mod tests;
