//! The pixels of a window that have a say in its fit.

use pulp::Simd;

use super::row::{Row, WIDTH};

/// The significant pixels of one window, a list per property. Buffers are kept between fits.
#[derive(Debug, Default)]
pub struct Neighbours {
    /// Their index in the picture.
    pub pixels: Vec<u32>,
    /// Their index in the sums of the tile.
    pub places: Vec<u32>,
    /// Weight with which each takes the fit's prediction.
    pub kernel: Vec<f32>,
    /// Weight of each one's residual in the fit.
    pub weights: Vec<f32>,
    /// Their rows relative to the centre's.
    pub rows: Vec<Row>,
}

impl Neighbours {
    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.pixels.clear();
        self.places.clear();
        self.kernel.clear();
    }

    /// Takes in the pixel `pixel`, which lies at `place` of the tile's sums.
    #[inline(always)]
    pub fn push(&mut self, pixel: usize, place: usize, kernel: f32) {
        self.pixels.push(pixel as u32);
        self.places.push(place as u32);
        self.kernel.push(kernel);
    }

    /// Fetches rows and weights of all pixels, relative to those of the pixel `centre`.
    #[inline(always)]
    pub fn fetch<S: Simd>(&mut self, simd: S, rows: &[Row], importance: Option<&[f32]>, centre: usize) {
        self.rows.resize(self.pixels.len(), [0.0; WIDTH]);
        let own = S::as_simd_f32s(&rows[centre]).0;
        for (row, pixel) in self.rows.iter_mut().zip(&self.pixels) {
            let from = S::as_simd_f32s(&rows[*pixel as usize]).0;
            for (to, (from, own)) in S::as_mut_simd_f32s(row).0.iter_mut().zip(from.iter().zip(own)) {
                *to = simd.sub_f32s(*from, *own);
            }
        }
        self.weights.clear();
        match importance {
            None => self.weights.extend_from_slice(&self.kernel),
            Some(importance) => {
                let own = 1.0 / importance[centre];
                let weight = |(kernel, pixel): (&f32, &u32)| kernel * importance[*pixel as usize] * own;
                self.weights.extend(self.kernel.iter().zip(&self.pixels).map(weight));
            }
        }
    }
}

#[cfg(test)]
mod tests;
