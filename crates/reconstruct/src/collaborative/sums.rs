//! Predictions added up by weight.

use stack::{Image, Size};

use super::plane::Prediction;
use super::row::RESPONSES;
use crate::rectangle::Rectangle;

/// Per pixel, responses and weights added up.
#[derive(Clone, Debug)]
pub struct Sums {
    size: Size,
    values: Vec<Prediction>,
}

impl Sums {
    /// Nothing yet.
    pub fn zeros(size: Size) -> Self {
        Self { size, values: vec![[0.0; _]; size.pixels()] }
    }

    /// The sums of pixel `index`.
    #[inline(always)]
    pub fn at_mut(&mut self, index: usize) -> &mut Prediction {
        &mut self.values[index]
    }

    /// Adds `part`, which lies at `place`.
    pub fn add(&mut self, place: Rectangle, part: &Self) {
        for (y, row) in (place.y0..place.y1).zip(part.values.chunks_exact(place.width())) {
            let start = self.size.index(place.x0, y);
            for (to, from) in self.values[start..start + row.len()].iter_mut().zip(row) {
                to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
            }
        }
    }

    /// Which pixels have got less weight than `least`.
    pub fn lighter_than(&self, least: f32) -> Vec<bool> {
        self.values.iter().map(|sum| sum[RESPONSES] < least).collect()
    }

    /// The weighted means: both halves.
    pub fn into_halves(self) -> [Image; 2] {
        let plane = |c: usize| self.values.iter().map(|sum| sum[c] / sum[RESPONSES].max(1e-20)).collect();
        [0, 3].map(|first| Image::from_channels(self.size, (first..first + 3).map(plane).collect()))
    }
}

#[cfg(test)]
mod tests;
