//! One block: polynomials of every order fitted to it at once, and the error of each (Moon et al. 2016, section 4).

use pulp::Simd;

use super::factor::factor_dropping;
use crate::regression::field::Field;
use crate::regression::lanes::{Lanes, MOST_LANES};
use crate::regression::normal_equations::NormalEquations;
use crate::regression::window::Window;

/// Orders 0, 1, 2 and 3 can be chosen from.
pub(crate) const ORDERS: usize = 4;
/// How many terms u^a v^b with 0 < a + b ≤ order each has.
const TERMS: [usize; ORDERS] = [0, 2, 5, 9];
/// A direction of the block whose mean square is smaller than this is as good as none.
const LEAST_SQUARE: f32 = 1e-5;

/// What the blocks around neighbouring pixels are fitted to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fitted<'a> {
    /// Features, colour and variance.
    pub(crate) field: &'a Field,
    /// The picture that the stage before made: what bias is measured against. `None` in the first stage.
    pub(crate) previous: Option<&'a Field>,
    /// Highest order to choose from.
    pub(crate) highest: usize,
}

/// The blocks around the pixels worked on side by side.
///
/// With the rows x_i = (1, features, polynomial terms) of a block, XᵀX = RᵀR and q_i = R⁻ᵀx_i, the fit of an order that
/// uses the first m terms is ŷ_i = Σ_{j<m} q_ij c_j, c = Σ q_i y_i, its hat matrix has the diagonal Σ_{j<m} q_ij², and its
/// residuals the sum of squares Σ y² − Σ_{j<m} c_j²: one factorisation serves all orders.
#[derive(Debug)]
pub(crate) struct Blocks<S: Simd> {
    simd: S,
    normal: NormalEquations<S>,
    /// q_i of every neighbour, `unknowns` numbers each.
    basis: Vec<Lanes<S>>,
    unknowns: usize,
    inverse: Vec<Lanes<S>>,
    /// Σ over the block of the variance of each order's fit, mean over channels.
    spread: [Lanes<S>; ORDERS],
    /// Σ over the block of the input's variance, mean over channels.
    noise: Lanes<S>,
    /// Pixels of each block.
    count: Lanes<S>,
    /// Chosen order of each block.
    pub(crate) order: [usize; MOST_LANES],
    /// Mean squared error of the chosen order over each block, mean over channels.
    pub(crate) error: Lanes<S>,
}

impl<S: Simd> Blocks<S> {
    /// Room for blocks of `field`.
    pub(crate) fn new(simd: S, field: &Field) -> Self {
        let zero = Lanes::splat(simd, 0.0);
        let most = 1 + field.features + TERMS[ORDERS - 1];
        let neighbours = (2 * field.radius + 1).pow(2);
        Self {
            simd,
            normal: NormalEquations::with_capacity(simd, (most + 6).next_multiple_of(2)),
            basis: vec![zero; neighbours * most],
            unknowns: 0,
            inverse: vec![zero; most],
            spread: [zero; ORDERS],
            noise: zero,
            count: zero,
            order: [0; MOST_LANES],
            error: zero,
        }
    }

    /// Fits the blocks around the pixels that `window` stands on and chooses an order for each.
    #[inline(always)]
    pub(crate) fn fit(&mut self, fitted: &Fitted, window: &Window<S>) {
        let field = fitted.field;
        self.unknowns = 1 + field.features + TERMS[fitted.highest];
        let responses = if fitted.previous.is_some() { 6 } else { 3 };
        self.normal.begin((self.unknowns + responses).next_multiple_of(2));
        for (row, y) in window.rows.clone().enumerate() {
            for column in 0..=2 * field.radius {
                self.add_neighbour(fitted, window, row, y, column);
            }
        }
        self.normal.finish();
        self.count = self.normal.matrix[0];
        let width = self.normal.width;
        let rows = &mut self.normal.matrix[..self.unknowns * width];
        let (shape, least) = ((self.unknowns, width), self.count * LEAST_SQUARE);
        factor_dropping(self.simd, rows, shape, least, &mut self.inverse);
        self.find_basis(field, window);
        self.choose(fitted);
    }

    /// Values of (features, polynomial terms) at a neighbour, `inside` being 0 for one that is not there.
    #[inline(always)]
    fn write_row(
        &self,
        field: &Field,
        window: &Window<S>,
        (y, column): (usize, usize),
        inside: Lanes<S>,
        to: &mut [Lanes<S>],
    ) {
        let simd = self.simd;
        to[0] = inside;
        for feature in 0..field.features {
            let centre = field.at(simd, feature, window.x, window.y);
            let value = Lanes::load(simd, &field.row(feature, window.x, y)[column..]);
            to[1 + feature] = (value - centre) * inside;
        }
        let scale = 1.0 / field.radius.max(1) as f32;
        let u = (column as f32 - field.radius as f32) * scale;
        let v = (y as f32 - window.y as f32) * scale;
        let terms = [u, v, u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v];
        for (to, term) in to[1 + field.features..self.unknowns].iter_mut().zip(terms) {
            *to = inside * term;
        }
    }

    #[inline(always)]
    fn add_neighbour(&mut self, fitted: &Fitted, window: &Window<S>, row: usize, y: usize, column: usize) {
        let (field, inside) = (fitted.field, window.inside[column]);
        let at = (row * (2 * field.radius + 1) + column) * self.unknowns;
        let mut values = std::mem::take(&mut self.basis);
        self.write_row(field, window, (y, column), inside, &mut values[at..at + self.unknowns]);
        let to = self.normal.next_row();
        to.fill(Lanes::splat(self.simd, 0.0));
        to[..self.unknowns].copy_from_slice(&values[at..at + self.unknowns]);
        self.basis = values;
        for (i, source) in [Some(field), fitted.previous].into_iter().flatten().enumerate() {
            for c in 0..3 {
                let plane = source.colour(c);
                let centre = source.at(self.simd, plane, window.x, window.y);
                let value = Lanes::load(self.simd, &source.row(plane, window.x, y)[column..]);
                to[self.unknowns + 3 * i + c] = (value - centre) * inside;
            }
        }
    }

    /// Turns every x_i into q_i by forward substitution, and adds up what its leverage makes of the noise.
    #[inline(always)]
    fn find_basis(&mut self, field: &Field, window: &Window<S>) {
        let (simd, width, unknowns) = (self.simd, self.normal.width, self.unknowns);
        let zero = Lanes::splat(simd, 0.0);
        self.spread = [zero; ORDERS];
        self.noise = zero;
        for (row, y) in window.rows.clone().enumerate() {
            for column in 0..=2 * field.radius {
                let at = (row * (2 * field.radius + 1) + column) * unknowns;
                let q = &mut self.basis[at..at + unknowns];
                for j in 0..unknowns {
                    q[j] = q[j] * self.inverse[j];
                    for k in j + 1..unknowns {
                        q[k] = q[k] - self.normal.matrix[j * width + k] * q[j];
                    }
                }
                let mut variance = zero;
                for c in 0..3 {
                    variance += Lanes::load(simd, &field.row(field.variance(c), window.x, y)[column..]);
                }
                let variance = variance * window.inside[column] * (1.0 / 3.0);
                self.noise += variance;
                let (mut leverage, mut done) = (zero, 0);
                for (order, terms) in TERMS.iter().enumerate() {
                    let upto = (1 + field.features + terms).min(unknowns);
                    for j in done..upto {
                        leverage += q[j].squared();
                    }
                    done = upto;
                    self.spread[order] += leverage * variance;
                }
            }
        }
    }

    /// Chooses the order of least estimated error, squared bias plus variance. In the first stage bias is what the
    /// residuals of the input hold beyond its noise; later it is the residual of the picture from the stage before.
    #[inline(always)]
    fn choose(&mut self, fitted: &Fitted) {
        let zero = Lanes::splat(self.simd, 0.0);
        let first = self.unknowns + if fitted.previous.is_some() { 3 } else { 0 };
        let (width, features) = (self.normal.width, fitted.field.features);
        let mut residual = zero;
        for c in first..first + 3 {
            residual += self.normal.matrix[c * width + c] * (1.0 / 3.0);
        }
        let (mut best, mut chosen, mut done) = (zero, zero, 0);
        for order in 0..=fitted.highest {
            let upto = 1 + features + TERMS[order];
            for j in done..upto {
                for c in first..first + 3 {
                    residual = residual - self.normal.matrix[j * width + c].squared() * (1.0 / 3.0);
                }
            }
            done = upto;
            let own_noise = if fitted.previous.is_some() { zero } else { self.noise - self.spread[order] };
            let error = (residual - own_noise).positive_part() + self.spread[order];
            let better = error.less_than(best);
            let better = if order == 0 { zero.equals(zero) } else { better };
            best = better.select(error, best);
            chosen = better.select(Lanes::splat(self.simd, order as f32), chosen);
        }
        self.error = best * self.count.reciprocal_or_zero();
        self.order = chosen.to_array().map(|order| order as usize);
        self.drop_higher_terms(chosen, features);
    }

    /// Leaves only the coefficients c_j of the chosen order.
    #[inline(always)]
    fn drop_higher_terms(&mut self, chosen: Lanes<S>, features: usize) {
        let zero = Lanes::splat(self.simd, 0.0);
        for order in 1..ORDERS {
            let lower = chosen.less_than(Lanes::splat(self.simd, order as f32));
            for j in 1 + features + TERMS[order - 1]..(1 + features + TERMS[order]).min(self.unknowns) {
                for c in 0..3 {
                    let at = j * self.normal.width + self.unknowns + c;
                    self.normal.matrix[at] = lower.select(zero, self.normal.matrix[at]);
                }
            }
        }
    }

    /// What the chosen order predicts for the neighbour in row `row` of the window, `column`, less the colour of the
    /// block's own pixel.
    #[inline(always)]
    pub(crate) fn prediction(&self, radius: usize, row: usize, column: usize) -> [Lanes<S>; 3] {
        let mut sums = [Lanes::splat(self.simd, 0.0); 3];
        let at = (row * (2 * radius + 1) + column) * self.unknowns;
        for (j, q) in self.basis[at..at + self.unknowns].iter().enumerate() {
            let coefficients = &self.normal.matrix[j * self.normal.width + self.unknowns..][..3];
            for c in 0..3 {
                sums[c] += *q * coefficients[c];
            }
        }
        sums
    }
}
