//! Which neighbours are believed: two tricks of the authors' program against fireflies.

use pulp::Simd;

use super::WlrSettings;
use crate::regression::field::Field;
use crate::regression::lanes::Lanes;
use crate::regression::window::{Trust, Window};

/// Added to the confidence interval, so that noiseless pixels may differ a little.
const CONFIDENCE_FLOOR: f32 = 0.005;
/// A pixel that stands alone may seem to weigh this much more than itself, by rounding.
const ROUNDING: f32 = 1.000_01;

/// One factor for each neighbour of the pixels worked on side by side.
#[derive(Debug)]
pub(crate) struct Reliability<S: Simd> {
    simd: S,
    columns: usize,
    factors: Vec<Lanes<S>>,
    own: Lanes<S>,
}

impl<S: Simd> Reliability<S> {
    /// Room for the windows of `field`.
    pub(crate) fn new(simd: S, field: &Field) -> Self {
        let zero = Lanes::splat(simd, 0.0);
        let columns = field.columns();
        Self { simd, columns, factors: vec![zero; columns * (2 * field.radius + 1)], own: zero }
    }

    /// Every neighbour weighs 1/max(variance, 1): in bright fireflies' variance, little.
    #[inline(always)]
    pub(crate) fn by_variance(&mut self, field: &Field, window: &Window<S>) {
        let one = Lanes::splat(self.simd, 1.0);
        for row in 0..window.rows.len() {
            for column in 0..self.columns {
                let (_, variance) = grey(self.simd, field, window.x, window.rows.start + row, column);
                self.factors[row * self.columns + column] = window.inside[column] / variance.max(one);
            }
        }
        let (_, variance) = grey(self.simd, field, window.x, window.y, field.radius);
        self.own = Lanes::splat(self.simd, ROUNDING) / variance.max(one);
    }

    /// Like `other`, but a neighbour whose grey value differs from the pixel's by more than
    /// c(σ_i + σ_c) + 0.005 is left out; c is the settings' `confidence`.
    #[inline(always)]
    pub(crate) fn by_confidence(&mut self, other: &Self, field: &Field, window: &Window<S>, settings: &WlrSettings) {
        let zero = Lanes::splat(self.simd, 0.0);
        let (centre, variance) = grey(self.simd, field, window.x, window.y, field.radius);
        let deviation = variance.sqrt();
        for row in 0..window.rows.len() {
            for column in 0..self.columns {
                let (value, variance) = grey(self.simd, field, window.x, window.rows.start + row, column);
                let bound = (variance.sqrt() + deviation) * settings.confidence + CONFIDENCE_FLOOR;
                let at = row * self.columns + column;
                self.factors[at] = bound.less_than((value - centre).abs()).select(zero, other.factors[at]);
            }
        }
        self.own = other.own;
    }
}

impl<S: Simd> Trust<S> for Reliability<S> {
    #[inline(always)]
    fn of(&self, row: usize, column: usize) -> Lanes<S> {
        self.factors[row * self.columns + column]
    }

    #[inline(always)]
    fn own(&self) -> Lanes<S> {
        self.own
    }
}

/// Mean of the three channels and of their variances, in picture row `y`, `column` of the window.
#[inline(always)]
fn grey<S: Simd>(simd: S, field: &Field, x: usize, y: usize, column: usize) -> (Lanes<S>, Lanes<S>) {
    let mean = |plane: [usize; 3]| {
        let [a, b, c] = plane.map(|plane| Lanes::load(simd, &field.row(plane, x, y)[column..]));
        (a + b + c) * (1.0 / 3.0)
    };
    (mean([0, 1, 2].map(|c| field.colour(c))), mean([0, 1, 2].map(|c| field.variance(c))))
}
