//! Distances between a pixel's patch and those of its window.

use pulp::Simd;

use super::fitted::Guides;
use super::region::Region;
use crate::eight::{Eight, LANES, Lanes};
use crate::rectangle::Rectangle;

/// Distance of pixels outside the image: no bandwidth makes a weight of it.
const FAR: f32 = 1e9;

/// Distances (equation 11) of one tile's fits, which are few among its pixels: each is compared by itself.
#[derive(Debug)]
pub struct WindowDistances<'a> {
    guides: &'a Guides<'a>,
    /// The variances, then the values of each picture, then 1 where the image has a pixel.
    region: Region,
}

/// One channel of one pixel of the patch around a fit.
struct Term<const PICTURES: usize> {
    variance: f32,
    values: [f32; PICTURES],
    /// Where the same numbers lie of the window's first pixel, and whether there is such a pixel.
    variance_at: usize,
    values_at: [usize; PICTURES],
    inside_at: usize,
}

impl<'a> WindowDistances<'a> {
    /// Compares patches of `guides` around the pixels of `tile`.
    pub fn new(guides: &'a Guides<'a>, tile: Rectangle) -> Self {
        let Guides { size, values, variances, .. } = *guides;
        let planes: Vec<&[f32]> = variances.iter().chain(values.iter().copied().flatten()).map(Vec::as_slice).collect();
        Self { guides, region: Region::cut(&planes, size, tile, guides.radius + guides.comparison.patch_radius) }
    }

    /// The distances of the pixel `fit` to those of its window, for some `pictures`: row by row in a list for each, rows
    /// padded to groups of eight with numbers that mean nothing.
    #[inline(always)]
    pub fn compute<S: Simd, const PICTURES: usize>(
        &self,
        simd: S,
        fit: [usize; 2],
        pictures: [usize; PICTURES],
        mut out: [&mut [Lanes]; PICTURES],
    ) {
        let Guides { size, radius, comparison, .. } = *self.guides;
        let reach = radius + comparison.patch_radius;
        let [x, y] = fit;
        let is_inside = x >= reach && y >= reach && x + reach < size.width && y + reach < size.height;
        let comparing = Comparing { distances: self, fit, terms: self.terms(fit, pictures) };
        if is_inside {
            comparing.rows::<S, false>(simd, &mut out);
        } else {
            comparing.rows::<S, true>(simd, &mut out);
        }
    }

    /// What is summed over a patch.
    fn terms<const PICTURES: usize>(&self, [x, y]: [usize; 2], pictures: [usize; PICTURES]) -> Vec<Term<PICTURES>> {
        let Guides { size, variances, comparison, radius, .. } = *self.guides;
        let patch = Rectangle::around([x, y], comparison.patch_radius, size);
        let pixels = (patch.y0..patch.y1).flat_map(|y| (patch.x0..patch.x1).map(move |x| [x, y]));
        let channels = variances.len();
        let term = |[x, y]: [usize; 2], channel: usize| {
            let to_window = radius * (self.region.width() + 1);
            let inside_at = self.region.inside_index(x, y) - to_window;
            let planes = pictures.map(|picture| (picture + 1) * channels + channel);
            let variance = self.region.index(channel, x, y);
            let values = planes.map(|plane| self.region.index(plane, x, y));
            Term {
                variance: self.region.from(variance)[0],
                values: values.map(|index| self.region.from(index)[0]),
                variance_at: variance - to_window,
                values_at: values.map(|index| index - to_window),
                inside_at,
            }
        };
        pixels.flat_map(|pixel| (0..channels).map(move |channel| term(pixel, channel))).collect()
    }
}

/// One fit's comparison with its window. Where `BORDER`, pairs of which one lies outside the image do not count.
struct Comparing<'d, const PICTURES: usize> {
    distances: &'d WindowDistances<'d>,
    fit: [usize; 2],
    terms: Vec<Term<PICTURES>>,
}

impl<const PICTURES: usize> Comparing<'_, PICTURES> {
    #[inline(always)]
    fn rows<S: Simd, const BORDER: bool>(&self, simd: S, out: &mut [&mut [Lanes]; PICTURES]) {
        let WindowDistances { guides, region } = self.distances;
        let groups = guides.groups();
        for row in 0..guides.side() {
            let mut group = 0;
            while group < groups {
                let (place, at) = (row * region.width() + group * LANES, row * groups + group);
                // As many as the processor has registers for.
                group += match groups - group {
                    1 => self.batch::<S, 1, BORDER>(simd, place, at, out),
                    2 => self.batch::<S, 2, BORDER>(simd, place, at, out),
                    3 => self.batch::<S, 3, BORDER>(simd, place, at, out),
                    _ => self.batch::<S, 4, BORDER>(simd, place, at, out),
                };
            }
        }
    }

    /// `B` groups of eight pixels, from `place` in the window on, into `out` from number `at` on; `B`.
    #[inline(always)]
    fn batch<S: Simd, const B: usize, const BORDER: bool>(
        &self,
        simd: S,
        place: usize,
        at: usize,
        out: &mut [&mut [Lanes]; PICTURES],
    ) -> usize {
        let WindowDistances { guides, region } = self.distances;
        let [zero, one] = [0.0, 1.0].map(|value| Eight::splat(simd, value));
        let (epsilon, taken_off) = (guides.comparison.epsilon, guides.comparison.noise_taken_off);
        let (mut noise, mut squares, mut count) = ([zero; B], [[zero; B]; PICTURES], [zero; B]);
        for term in &self.terms {
            let variances = &region.from(term.variance_at + place)[..B * LANES];
            let inside = if BORDER { &region.from(term.inside_at + place)[..B * LANES] } else { &[] };
            let [here, tolerated] = [term.variance, term.variance + epsilon].map(|value| Eight::splat(simd, value));
            let mut scale = [zero; B];
            for b in 0..B {
                let there = Eight::load(simd, &variances[b * LANES..]);
                scale[b] = one.div(simd, tolerated.add(simd, there));
                if BORDER {
                    let inside = Eight::load(simd, &inside[b * LANES..]);
                    count[b] = count[b].add(simd, inside);
                    scale[b] = scale[b].mul(simd, inside);
                }
                if taken_off != 0.0 {
                    noise[b] = here.add(simd, here.min(simd, there)).mul_add(simd, scale[b], noise[b]);
                }
            }
            for p in 0..PICTURES {
                let values = &region.from(term.values_at[p] + place)[..B * LANES];
                let here = Eight::splat(simd, term.values[p]);
                for b in 0..B {
                    let difference = here.sub(simd, Eight::load(simd, &values[b * LANES..]));
                    squares[p][b] = difference.mul(simd, difference).mul_add(simd, scale[b], squares[p][b]);
                }
            }
        }
        let less_noise = Eight::splat(simd, -taken_off);
        let share = Eight::splat(simd, 1.0 / self.terms.len() as f32);
        for b in 0..B {
            for p in 0..PICTURES {
                let sum = noise[b].mul_add(simd, less_noise, squares[p][b]).max(simd, zero);
                out[p][at + b] = if BORDER {
                    let start = region.inside_index(self.fit[0], self.fit[1]) - guides.radius * (region.width() + 1);
                    let inside = Eight::load(simd, region.from(start + place + b * LANES));
                    let outside = Eight::splat(simd, FAR).mul(simd, one.sub(simd, inside));
                    sum.div(simd, count[b].max(simd, one)).mul_add(simd, inside, outside).lanes()
                } else {
                    sum.mul(simd, share).lanes()
                };
            }
        }
        B
    }
}

/// Offsets [dx, dy] of a window, row by row.
pub fn offsets(radius: usize) -> impl Iterator<Item = [isize; 2]> {
    let reach = radius as isize;
    (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| [dx, dy]))
}

#[cfg(test)]
mod tests;
