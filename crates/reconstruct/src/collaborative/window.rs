//! The pixels of a window that have a say in its fit.

use std::ops::Range;

use pulp::Simd;

use super::fitted::Guides;
use super::region::Region;
use super::row::WIDTH;
use crate::eight::{Eight, LANES, Lanes};
use crate::exp::exp_of_negative;

/// Pixels of less weight have no say in a fit, nor it in them.
const NEGLIGIBLE: f32 = 1e-4;

/// Features whose weighted mean square, relative to the centre, is smaller are left out of a fit: the ridge would leave
/// nothing of them.
const CONSTANT: f32 = 1e-10;

/// Which planes of a region are what.
#[derive(Clone, Debug)]
pub struct Layout {
    /// The first so many are features.
    pub features: usize,
    /// The responses of one guide.
    pub responses: Range<usize>,
    /// Relative variance.
    pub noise: usize,
    /// Factor on the weights of residuals.
    pub importance: Option<usize>,
}

/// Groups of eight neighbours, one of which at least has some weight; lists go group by group. Buffers are kept between
/// fits.
#[derive(Debug)]
pub struct Window {
    /// Groups in a row of the whole window.
    groups: usize,
    /// Values of a region from one row to the next.
    region_width: usize,
    /// How many groups there are; the lists have room for all of the window's.
    count: usize,
    places: Vec<usize>,
    kernel: Vec<Lanes>,
    weights: Vec<Lanes>,
    columns: Vec<Lanes>,
    features: usize,
    responses: usize,
}

impl Window {
    /// For windows of `guides` in regions whose rows have `region_width` values.
    pub fn new(guides: &Guides, region_width: usize) -> Self {
        let all = guides.groups() * guides.side();
        let [kernel, weights, columns] = [1, 1, WIDTH].map(|lists| vec![[0.0; LANES]; lists * all]);
        let (groups, places) = (guides.groups(), vec![0; all]);
        Self { groups, region_width, count: 0, places, kernel, weights, columns, features: 0, responses: 0 }
    }

    /// Weights exp(−D `scale` − `falloff`) of the patches' `distances` D, both row by row in groups that are padded with a
    /// falloff beyond all reach; the small ones are zero.
    #[inline(always)]
    pub fn weigh(&mut self, distances: &[Lanes], scale: f32, falloff: &[Lanes]) {
        self.count = 0;
        for (row, (distances, falloff)) in
            distances.chunks_exact(self.groups).zip(falloff.chunks_exact(self.groups)).enumerate()
        {
            for (group, (distances, falloff)) in distances.iter().zip(falloff).enumerate() {
                let mut weights = [0.0; LANES];
                for i in 0..LANES {
                    let weight = exp_of_negative(-(distances[i] * scale + falloff[i]));
                    weights[i] = if weight >= NEGLIGIBLE { weight } else { 0.0 };
                }
                // The next group takes the place of one that counts for nothing.
                self.kernel[self.count] = weights;
                self.places[self.count] = row * self.region_width + group * LANES;
                let bits = weights.iter().fold(0, |bits, weight| bits | weight.to_bits());
                self.count += usize::from(bits != 0);
            }
        }
    }

    /// Fetches what the pixels around `centre` are in `region`: features that vary among them, and responses, both
    /// relative to the centre's; and the weights of their residuals.
    #[inline(always)]
    pub fn fetch<S: Simd>(&mut self, simd: S, region: &Region, centre: [usize; 2], layout: &Layout) {
        let mut total = Eight::splat(simd, 0.0);
        self.kernel().iter().for_each(|kernel| total = total.add(simd, Eight::of(simd, kernel)));
        let least = CONSTANT * total.sum();
        self.features = 0;
        for plane in 0..layout.features {
            if self.fetch_column(simd, region, centre, plane, self.features) > least {
                self.features += 1;
            }
        }
        self.responses = layout.responses.len();
        for (number, plane) in layout.responses.clone().enumerate() {
            self.fetch_column(simd, region, centre, plane, self.features + number);
        }
        let (kernel, weights) = (&self.kernel[..self.count], &mut self.weights[..self.count]);
        let Some(plane) = layout.importance else {
            weights.copy_from_slice(kernel);
            return;
        };
        let start = region.window_index(plane, centre);
        let own = Eight::splat(simd, 1.0 / region.from(region.index(plane, centre[0], centre[1]))[0]);
        for ((weights, kernel), place) in weights.iter_mut().zip(kernel).zip(&self.places) {
            let importance = Eight::load(simd, region.from(start + place)).mul(simd, own);
            *weights = Eight::of(simd, kernel).mul(simd, importance).lanes();
        }
    }

    /// Makes list `number` from `plane`; the sum of its weighted squares.
    #[inline(always)]
    fn fetch_column<S: Simd>(
        &mut self,
        simd: S,
        region: &Region,
        [x, y]: [usize; 2],
        plane: usize,
        number: usize,
    ) -> f32 {
        let start = region.window_index(plane, [x, y]);
        let own = Eight::splat(simd, region.from(region.index(plane, x, y))[0]);
        let mut squares = Eight::splat(simd, 0.0);
        let column = &mut self.columns[number * self.count..][..self.count];
        for ((to, kernel), place) in column.iter_mut().zip(&self.kernel).zip(&self.places) {
            let value = Eight::load(simd, region.from(start + place)).sub(simd, own);
            squares = value.mul(simd, value).mul_add(simd, Eight::of(simd, kernel), squares);
            *to = value.lanes();
        }
        squares.sum()
    }

    /// Σ k² ν over the window, k what predictions weigh and ν the `noise` plane of `region`.
    #[inline(always)]
    pub fn noise<S: Simd>(&self, simd: S, region: &Region, centre: [usize; 2], layout: &Layout) -> f32 {
        let start = region.window_index(layout.noise, centre);
        let mut sum = Eight::splat(simd, 0.0);
        for (kernel, place) in self.kernel().iter().zip(&self.places) {
            let kernel = Eight::of(simd, kernel);
            sum = kernel.mul(simd, kernel).mul_add(simd, Eight::load(simd, region.from(start + place)), sum);
        }
        sum.sum()
    }

    /// How many features vary.
    pub fn features(&self) -> usize {
        self.features
    }

    /// Features that vary, then responses, relative to the centre's.
    #[inline(always)]
    pub fn columns(&self) -> Columns<'_> {
        let mut columns: Columns = [&[]; WIDTH];
        for number in 0..self.features + self.responses {
            columns[number] = &self.columns[number * self.count..][..self.count];
        }
        columns
    }

    /// What predictions weigh.
    pub fn kernel(&self) -> &[Lanes] {
        &self.kernel[..self.count]
    }

    /// What residuals weigh.
    pub fn weights(&self) -> &[Lanes] {
        &self.weights[..self.count]
    }

    /// Where each group begins, relative to the first pixel of the window, in planes as wide as the region.
    pub fn places(&self) -> &[usize] {
        &self.places[..self.count]
    }
}

/// Lists of a window; what there is less of is empty.
pub type Columns<'a> = [&'a [Lanes]; WIDTH];

#[cfg(test)]
mod tests;
