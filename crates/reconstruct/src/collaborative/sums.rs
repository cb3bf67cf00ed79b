//! Predictions added up by weight.

use stack::Size;

use crate::rectangle::Rectangle;

/// Per pixel, responses and weights added up: one plane for each response, then one of the weights.
#[derive(Clone, Debug)]
pub struct Sums {
    size: Size,
    planes: Vec<Vec<f32>>,
}

impl Sums {
    /// Nothing yet.
    pub fn zeros(size: Size, responses: usize) -> Self {
        Self { size, planes: vec![vec![0.0; size.pixels()]; responses + 1] }
    }

    /// Adds the `predictions` of a window of `side` × `side` pixels, list after list and multiplied by `weights`
    /// already, whose first pixel is number `first`.
    #[inline(always)]
    pub fn add_window(&mut self, first: usize, side: usize, predictions: &[f32], weights: &[f32]) {
        let (width, last) = (self.size.width, self.planes.len() - 1);
        for (number, plane) in self.planes.iter_mut().enumerate() {
            let list = if number == last { weights } else { &predictions[number * weights.len()..][..weights.len()] };
            for row in 0..side {
                let (to, from) = (&mut plane[first + row * width..][..side], &list[row * side..][..side]);
                for i in 0..side {
                    to[i] += from[i];
                }
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
        self.planes[self.planes.len() - 1].iter().map(|weight| *weight < least).collect()
    }

    /// The weighted means, one plane per response.
    pub fn into_means(mut self) -> Vec<Vec<f32>> {
        let weights = self.planes.pop().unwrap_or_default();
        for plane in &mut self.planes {
            plane.iter_mut().zip(&weights).for_each(|(sum, weight)| *sum /= weight.max(1e-20));
        }
        self.planes
    }
}

#[cfg(test)]
mod tests;
