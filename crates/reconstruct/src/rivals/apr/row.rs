//! All blocks whose centres lie in one row of pixels, and what they predict for the rows around it.

use pulp::{Simd, WithSimd};

use super::block::{Blocks, Fitted};
use crate::regression::field::Field;
use crate::regression::lanes::{Lanes, MOST_LANES};
use crate::regression::window::Window;

/// A prediction that misses the pixel it is for by more than this many of its standard deviations loses weight.
const CONFIDENCE: f32 = 3.0;
/// Weighted sums of predictions: three colours, the error, the weight.
pub(crate) const SUMS: usize = 5;
/// A block's error is taken for no less than this share of the mean square of its pixel's colour.
const LEAST_ERROR: f32 = 1e-8;

/// Fits the blocks around the pixels of row `y`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowOfBlocks<'a> {
    pub(crate) fitted: Fitted<'a>,
    pub(crate) y: usize,
}

/// What they predict.
#[derive(Clone, Debug)]
pub(crate) struct Predictions {
    /// Rows of the picture that are predicted.
    pub(crate) rows: std::ops::Range<usize>,
    /// For each of them, [`SUMS`] rows of sums.
    pub(crate) sums: Vec<f32>,
    /// Order of each block.
    pub(crate) orders: Vec<usize>,
    /// Numbers in a row of sums; the first `radius` belong to no pixel.
    pub(crate) stride: usize,
}

impl WithSimd for RowOfBlocks<'_> {
    type Output = Predictions;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Predictions {
        let field = self.fitted.field;
        let width = field.size.width;
        let (mut window, mut blocks) = (Window::new(simd, field), Blocks::new(simd, field));
        let mut predictions = Predictions::new(field, self.y);
        for start in (0..width).step_by(Lanes::<S>::COUNT) {
            window.move_to(field, start, self.y);
            blocks.fit(&self.fitted, &window);
            predictions.orders.extend(&blocks.order[..Lanes::<S>::COUNT.min(width - start)]);
            predictions.add(simd, field, &window, &blocks);
        }
        predictions
    }
}

impl Predictions {
    fn new(field: &Field, y: usize) -> Self {
        let rows = y.saturating_sub(field.radius)..(y + field.radius + 1).min(field.size.height);
        let stride = field.size.width + 2 * field.radius + 2 * MOST_LANES;
        let sums = vec![0.0; rows.len() * SUMS * stride];
        Self { rows, sums, orders: Vec::with_capacity(field.size.width), stride }
    }

    /// Adds what `blocks` predict, weighted by the inverse of their error and of what the pixel contradicts them by. (The
    /// inverse root keeps half a percent more energy at a quarter more error.)
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, field: &Field, window: &Window<S>, blocks: &Blocks<S>) {
        let centre = [0, 1, 2].map(|c| field.at(simd, field.colour(c), window.x, window.y));
        let brightness = centre[0].squared() + centre[1].squared() + centre[2].squared();
        let error = blocks.error.max((brightness + 1e-6) * LEAST_ERROR);
        // Lanes past the end of the row stand on no pixel.
        let mut real = [0.0; MOST_LANES];
        real[..(field.size.width - window.x).min(MOST_LANES)].fill(1.0);
        let real = Lanes::load(simd, &real);
        for row in 0..window.rows.len() {
            for column in 0..=2 * field.radius {
                let predicted = blocks.prediction(field.radius, row, column);
                let predicted = [predicted[0] + centre[0], predicted[1] + centre[1], predicted[2] + centre[2]];
                let missed = unexplained(simd, field, (window.x, window.rows.start + row, column), predicted);
                let weight = real * window.inside[column] / (error + missed);
                let values = [predicted[0], predicted[1], predicted[2], error];
                for (i, value) in values.into_iter().enumerate() {
                    self.add_lanes(simd, row * SUMS + i, window.x + column, value * weight);
                }
                self.add_lanes(simd, row * SUMS + SUMS - 1, window.x + column, weight);
            }
        }
    }

    #[inline(always)]
    fn add_lanes<S: Simd>(&mut self, simd: S, row: usize, x: usize, value: Lanes<S>) {
        let to = &mut self.sums[row * self.stride + x..];
        (Lanes::load(simd, to) + value).store(to);
    }
}

/// By how much the squared distance between `predicted` and the colour in picture row `y`, `column` of the window,
/// exceeds what its noise explains; mean over channels.
#[inline(always)]
fn unexplained<S: Simd>(
    simd: S,
    field: &Field,
    (x, y, column): (usize, usize, usize),
    predicted: [Lanes<S>; 3],
) -> Lanes<S> {
    let mut sum = Lanes::splat(simd, 0.0);
    for (c, predicted) in predicted.into_iter().enumerate() {
        let value = Lanes::load(simd, &field.row(field.colour(c), x, y)[column..]);
        let variance = Lanes::load(simd, &field.row(field.variance(c), x, y)[column..]);
        sum += (predicted - value).squared() - variance * (CONFIDENCE * CONFIDENCE);
    }
    sum.positive_part() * (1.0 / 3.0)
}
