//! Predictions added up by weight.

use pulp::Simd;
use rayon::prelude::*;
use stack::{Size, planes_of_zeros};

use crate::eight::{Eight, LANES, Lanes};
use crate::rectangle::Rectangle;

/// Per pixel, responses and weights added up: one plane for each response, then one of the weights.
#[derive(Clone, Debug)]
pub struct Sums {
    size: Size,
    /// A few more numbers follow the last pixel, for groups of eight that begin with it.
    planes: Vec<Vec<f32>>,
}

impl Sums {
    /// Nothing yet.
    pub fn zeros(size: Size, responses: usize) -> Self {
        Self { size, planes: planes_of_zeros(size.pixels() + LANES - 1, responses + 1) }
    }

    /// Adds the `predictions` of a fit in groups of eight, list after list and multiplied by `weights` already. Groups lie
    /// at `places` counted from pixel number `first`; what reaches past the end of a row has no weight.
    #[inline(always)]
    pub fn add_groups<S: Simd>(
        &mut self,
        simd: S,
        first: usize,
        places: &[usize],
        predictions: &[Lanes],
        weights: &[Lanes],
    ) {
        let last = self.planes.len() - 1;
        for (number, plane) in self.planes.iter_mut().enumerate() {
            let list = if number == last { weights } else { &predictions[number * weights.len()..][..weights.len()] };
            for (place, group) in places.iter().zip(list) {
                let to = &mut plane[first + place..][..LANES];
                Eight::load(simd, to).add(simd, Eight::of(simd, group)).store(to);
            }
        }
    }

    /// Adds `part`, the sums of `tile` and a margin around it, as far as they lie in this picture.
    pub fn add(&mut self, tile: Rectangle, margin: usize, part: &Self) {
        let place = tile.grown(margin, self.size);
        for (plane, part_plane) in self.planes.iter_mut().zip(&part.planes) {
            for y in place.y0..place.y1 {
                let from = (y + margin - tile.y0) * part.size.width + place.x0 + margin - tile.x0;
                let to = &mut plane[self.size.index(place.x0, y)..][..place.width()];
                to.iter_mut().zip(&part_plane[from..]).for_each(|(to, from)| *to += from);
            }
        }
    }

    /// Which pixels have got less weight than `least`.
    pub fn lighter_than(&self, least: f32) -> Vec<bool> {
        self.planes[self.planes.len() - 1][..self.size.pixels()].iter().map(|weight| *weight < least).collect()
    }

    /// The weighted means, one plane per response.
    pub fn into_means(mut self) -> Vec<Vec<f32>> {
        let weights = self.planes.pop().unwrap_or_default();
        for plane in &mut self.planes {
            plane.truncate(self.size.pixels());
            plane.par_iter_mut().zip(&weights).for_each(|(sum, weight)| *sum /= weight.max(1e-20));
        }
        self.planes
    }
}

#[cfg(test)]
mod tests;
