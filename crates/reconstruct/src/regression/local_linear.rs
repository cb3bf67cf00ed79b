//! The local linear estimate of a pixel, its equivalent kernel and its error (eqs. 2–7).

use pulp::Simd;

use super::bandwidth::Projection;
use super::cholesky::{factor, first_row_of_inverse};
use super::field::Field;
use super::lanes::{Lanes, Mask};
use super::neighbours::Neighbours;
use super::normal_equations::NormalEquations;
use super::window::{Trust, Window};

stack::knobs! {
    /// The local linear estimate (eqs. 2–7).
    pub struct LocalLinearSettings("regression") {
        /// Ridge on the slopes, as a share of the kernel's weight. The mean is not held back, so that the equivalent
        /// kernel sums to one.
        ridge: f32 = 1e-5, 1e-7..=1.0;
    }
}

/// The estimate of the pixels worked on side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate<S: Simd> {
    /// α̂ of each channel (eq. 4).
    pub(crate) colour: [Lanes<S>; 3],
    /// Mean squared error (eq. 7), mean over the channels.
    pub(crate) mse: Lanes<S>,
    /// Bias (eq. 5), mean over the channels.
    pub(crate) bias: Lanes<S>,
    /// Variance (eq. 6), mean over the channels.
    pub(crate) variance: Lanes<S>,
}

impl<S: Simd> Estimate<S> {
    #[inline(always)]
    fn replaced_where(self, mask: Mask<S>, other: Self) -> Self {
        let colour = [0, 1, 2].map(|c| mask.select(other.colour[c], self.colour[c]));
        let [mse, bias, variance] = [(other.mse, self.mse), (other.bias, self.bias), (other.variance, self.variance)]
            .map(|(yes, no)| mask.select(yes, no));
        Self { colour, mse, bias, variance }
    }
}

/// The regression, and the room to make it in.
#[derive(Debug)]
pub(crate) struct LocalLinear<S: Simd> {
    simd: S,
    /// Indices of the neighbours with a weight.
    near: Vec<usize>,
    /// Their weights, later the equivalent kernel l_i.
    kernel: Vec<Lanes<S>>,
    /// 1/(h b_j).
    narrow: Vec<Lanes<S>>,
    inverse_row: Vec<Lanes<S>>,
    normal: NormalEquations<S>,
}

impl<S: Simd> LocalLinear<S> {
    /// Room for the windows of `field`.
    pub(crate) fn new(simd: S, field: &Field) -> Self {
        let zeros = |n| vec![Lanes::splat(simd, 0.0); n];
        let most = field.features.next_multiple_of(2).max(2);
        let neighbours = field.columns() * (2 * field.radius + 1);
        Self {
            simd,
            near: Vec::with_capacity(neighbours),
            kernel: Vec::with_capacity(neighbours),
            narrow: zeros(most),
            inverse_row: zeros(most + 1),
            normal: NormalEquations::with_capacity(simd, most + 2),
        }
    }

    /// The estimate with bandwidths h·`factors`, and where no neighbour had a weight: there the pixel was kept as it is.
    #[inline(always)]
    pub(crate) fn estimate(
        &mut self,
        neighbours: &Neighbours<S, impl Trust<S>>,
        factors: &[Lanes<S>],
        settings: &LocalLinearSettings,
    ) -> (Estimate<S>, Mask<S>) {
        let Neighbours { field, window, projection, rank, trust } = *neighbours;
        let one = Lanes::splat(self.simd, 1.0);
        for j in 0..rank {
            self.narrow[j] = one / (projection.shared * factors[j]);
        }
        self.normal.begin((rank + 1).next_multiple_of(2));
        self.add(neighbours);
        // The pixel's own kernel weight is 1.
        let accompanied = trust.own().less_than(self.normal.matrix[0]);
        self.find_kernel(projection, rank, settings.ridge);
        (self.apply_kernel(field, window), accompanied.not())
    }

    /// The normal equations of eq. 4, in units of the bandwidth: Σ w (1, u)(1, u)ᵀ with u_j = z_j/(h b_j).
    #[inline(always)]
    fn add(&mut self, neighbours: &Neighbours<S, impl Trust<S>>) {
        let Neighbours { field, window, projection, rank, trust } = *neighbours;
        let (zero, one) = (Lanes::splat(self.simd, 0.0), Lanes::splat(self.simd, 1.0));
        self.near.clear();
        self.kernel.clear();
        for row in 0..window.rows.len() {
            for column in 0..window.inside.len() {
                let index = row * field.columns() + column;
                let z = &projection.of(index)[..rank];
                let mut weight = trust.of(row, column);
                for (z, narrow) in z.iter().zip(&self.narrow) {
                    weight = weight * (one - (*z * *narrow).squared()).positive_part();
                }
                if zero.less_than(weight).any() {
                    self.near.push(index);
                    self.kernel.push(weight);
                    let to = self.normal.next_row();
                    let root = weight.sqrt();
                    to[0] = root;
                    for ((to, z), narrow) in to[1..].iter_mut().zip(z).zip(&self.narrow) {
                        *to = root * (*z * *narrow);
                    }
                    to[rank + 1..].fill(zero);
                }
            }
        }
        self.normal.finish();
    }

    /// Turns weights into the equivalent kernel l_i = w_i (a₀ + Σ a_j u_ij), a being the first row of the inverse.
    #[inline(always)]
    fn find_kernel(&mut self, projection: &Projection<S>, rank: usize, ridge: f32) {
        let (unknowns, width) = (rank + 1, self.normal.width);
        let ridge = self.normal.matrix[0] * ridge;
        self.normal.add_ridge(1..unknowns, ridge);
        factor(self.simd, &mut self.normal.matrix[..unknowns * width], unknowns, width, ridge);
        first_row_of_inverse(self.simd, &self.normal.matrix, unknowns, width, &mut self.inverse_row);
        for j in 0..rank {
            self.inverse_row[j + 1] = self.inverse_row[j + 1] * self.narrow[j];
        }
        for (weight, index) in self.kernel.iter_mut().zip(&self.near) {
            let mut value = self.inverse_row[0];
            for (z, a) in projection.of(*index)[..rank].iter().zip(&self.inverse_row[1..]) {
                value += *z * *a;
            }
            *weight = *weight * value;
        }
    }

    /// Applies the kernel. A result that is negative in any channel is taken again without the kernel's negative
    /// weights, the others being rescaled to sum to one.
    #[inline(always)]
    fn apply_kernel(&mut self, field: &Field, window: &Window<S>) -> Estimate<S> {
        let zero = Lanes::splat(self.simd, 0.0);
        let mut estimate = self.weighted_sums(field, window);
        let mut negative = zero.less_than(zero);
        for colour in estimate.colour {
            negative = negative.or(colour.less_than(zero));
        }
        if negative.any() {
            self.drop_negative_weights();
            estimate = estimate.replaced_where(negative, self.weighted_sums(field, window));
        }
        estimate
    }

    #[inline(always)]
    fn drop_negative_weights(&mut self) {
        let mut sum = Lanes::splat(self.simd, 0.0);
        for weight in &mut self.kernel {
            *weight = weight.positive_part();
            sum += *weight;
        }
        let scale = sum.reciprocal_or_zero();
        for weight in &mut self.kernel {
            *weight = *weight * scale;
        }
    }

    /// α̂ = Σ l_i y_i (eq. 4), its bias α̂ − y_c (eq. 5), variance Σ l_i² var(y_i) (eq. 6) and mean squared error (eq. 7).
    #[inline(always)]
    fn weighted_sums(&self, field: &Field, window: &Window<S>) -> Estimate<S> {
        let (x, y) = (window.x, window.y);
        let centre = [0, 1, 2].map(|c| field.at(self.simd, field.colour(c), x, y));
        let mut bias = [Lanes::splat(self.simd, 0.0); 3];
        let mut variance = bias;
        for (weight, index) in self.kernel.iter().zip(&self.near) {
            let (row, column) = (window.rows.start + index / field.columns(), index % field.columns());
            for c in 0..3 {
                let colour = Lanes::load(self.simd, &field.row(field.colour(c), x, row)[column..]);
                let noise = Lanes::load(self.simd, &field.row(field.variance(c), x, row)[column..]);
                bias[c] += *weight * (colour - centre[c]);
                variance[c] += weight.squared() * noise;
            }
        }
        let mut mse = Lanes::splat(self.simd, 0.0);
        for c in 0..3 {
            mse += (bias[c].squared() + variance[c]) * (1.0 / 3.0);
        }
        let mean = |values: [Lanes<S>; 3]| (values[0] + values[1] + values[2]) * (1.0 / 3.0);
        let colour = [0, 1, 2].map(|c| centre[c] + bias[c]);
        Estimate { colour, mse, bias: mean(bias), variance: mean(variance) }
    }
}

#[cfg(test)]
mod tests {
    use pulp::Scalar256b;
    use stack::Size;

    use super::super::curvature::Curvature;
    use super::super::reduce::Reduction;
    use super::super::twin::Scene;
    use super::super::{Normalisation, RegressionSettings};
    use super::*;

    /// The equivalent kernel reproduces constants (it sums to one) and linear functions (its first moments vanish).
    #[test]
    fn the_equivalent_kernel_has_the_right_moments() {
        let scene = Scene::new(Size::new(32, 20), 0.1);
        let field = Field::new(&scene.input(), 5);
        let settings = RegressionSettings::default();
        let mut window = Window::new(Scalar256b, &field);
        let mut reduction = Reduction::new(Scalar256b, &field);
        let mut projection = Projection::new(Scalar256b, &field);
        let mut curvature = Curvature::new(Scalar256b, &field);
        let mut local_linear = LocalLinear::new(Scalar256b, &field);
        for (x, y) in [(0, 0), (8, 10), (16, 3), (24, 19)] {
            window.move_to(&field, x, y);
            reduction.find(&field, &mut window, Normalisation::Window, &settings.reduction);
            projection.find(&field, &window, &reduction, &settings.bandwidth);
            let rank = reduction.largest_rank;
            let neighbours =
                Neighbours { field: &field, window: &window, projection: &projection, rank, trust: &window };
            curvature.find(&neighbours, &settings.curvature);
            local_linear.estimate(&neighbours, &curvature.factors, &LocalLinearSettings { ridge: 1e-7 });
            let mut moments = vec![Lanes::splat(Scalar256b, 0.0); rank + 1];
            for (l, index) in local_linear.kernel.iter().zip(&local_linear.near) {
                moments[0] += *l;
                for (moment, z) in moments[1..].iter_mut().zip(projection.of(*index)) {
                    *moment += *l * *z;
                }
            }
            assert!(moments[0].to_array()[..8].iter().all(|sum| (sum - 1.0).abs() < 2e-5), "{:?}", moments[0]);
            for moment in &moments[1..] {
                assert!(moment.to_array().iter().all(|m| m.abs() < 1e-4), "{moment:?}");
            }
        }
    }
}
