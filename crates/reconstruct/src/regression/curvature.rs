//! How fast the picture bends along each reduced direction, and the bandwidth factors that follow (section 3.1).

use pulp::Simd;

use super::cholesky::{factor, substitute_back};
use super::field::Field;
use super::lanes::Lanes;
use super::neighbours::Neighbours;
use super::normal_equations::NormalEquations;
use super::window::Trust;

stack::knobs! {
    /// The bandwidth factors b_j (section 3.1, after Moon et al. 2014).
    pub struct CurvatureSettings("curvature") {
        /// Whether bandwidths follow the picture's curvature at all; without, every b_j is 1.
        adaptive: bool = true, ..;
        /// Ridge of the quadratic fit, as a share of the kernel's weight.
        ridge: f32 = 1e-3, 1e-6..=1.0;
        /// Added to the second derivative |H_j| in b_j = 1/√(|H_j| + floor).
        floor: f32 = 0.16, 1e-4..=100.0;
    }
}

/// The quadratic fit of the pixels worked on side by side, and the room to make it in.
#[derive(Debug)]
pub(crate) struct Curvature<S: Simd> {
    simd: S,
    /// b_j of each reduced direction.
    pub(crate) factors: Vec<Lanes<S>>,
    normal: NormalEquations<S>,
}

impl<S: Simd> Curvature<S> {
    /// Room for the windows of `field`.
    pub(crate) fn new(simd: S, field: &Field) -> Self {
        let most = field.features.next_multiple_of(2).max(2);
        let factors = vec![Lanes::splat(simd, 0.0); most];
        Self { simd, factors, normal: NormalEquations::with_capacity(simd, 2 * most + 4) }
    }

    /// Fits 1, z_j and z_j² (j < rank) to each colour channel with a kernel of bandwidth 1, H_j being twice the mean size
    /// of the coefficients of z_j².
    #[inline(always)]
    pub(crate) fn find(&mut self, neighbours: &Neighbours<S, impl Trust<S>>, settings: &CurvatureSettings) {
        let rank = neighbours.rank;
        if !settings.adaptive {
            self.factors[..rank].fill(Lanes::splat(self.simd, 1.0));
            return;
        }
        let (unknowns, width) = (2 * rank + 1, 2 * rank + 4);
        self.normal.begin(width);
        self.add(neighbours);
        let ridge = self.normal.matrix[0] * settings.ridge;
        self.normal.add_ridge(0..unknowns, ridge);
        let matrix = &mut self.normal.matrix;
        factor(self.simd, &mut matrix[..unknowns * width], unknowns, width, ridge);
        for channel in 0..3 {
            substitute_back(matrix, unknowns, width, unknowns + channel, rank + 1);
        }
        for j in 0..rank {
            let coefficients = &matrix[(rank + 1 + j) * width + unknowns..][..3];
            let sum = coefficients[0].abs() + coefficients[1].abs() + coefficients[2].abs();
            let second_derivative = sum * (2.0 / 3.0);
            self.factors[j] = Lanes::splat(self.simd, 1.0) / (second_derivative + settings.floor).sqrt();
        }
    }

    /// The normal equations of 1, z_j, z_j², and the colours in the last three columns.
    #[inline(always)]
    fn add(&mut self, neighbours: &Neighbours<S, impl Trust<S>>) {
        let Neighbours { field, window, projection, rank, trust } = *neighbours;
        let (zero, one) = (Lanes::splat(self.simd, 0.0), Lanes::splat(self.simd, 1.0));
        let centre = [0, 1, 2].map(|c| field.at(self.simd, field.colour(c), window.x, window.y));
        for (row, y) in window.rows.clone().enumerate() {
            let colour = [0, 1, 2].map(|c| field.row(field.colour(c), window.x, y));
            for column in 0..window.inside.len() {
                let z = &projection.of(row * field.columns() + column)[..rank];
                let mut weight = trust.of(row, column);
                for z in z {
                    weight = weight * (one - z.squared()).positive_part();
                }
                if zero.less_than(weight).any() {
                    let to = self.normal.next_row();
                    let root = weight.sqrt();
                    to[0] = root;
                    for (j, z) in z.iter().enumerate() {
                        to[1 + j] = root * *z;
                        to[1 + rank + j] = to[1 + j] * *z;
                    }
                    for c in 0..3 {
                        let value = Lanes::load(self.simd, &colour[c][column..]);
                        to[1 + 2 * rank + c] = root * (value - centre[c]);
                    }
                }
            }
        }
        self.normal.finish();
    }
}

#[cfg(test)]
mod tests {
    use pulp::Scalar;
    use stack::{Image, Size};

    use super::super::bandwidth::Projection;
    use super::super::reduce::Reduction;
    use super::super::twin::Scene;
    use super::super::window::Window;
    use super::super::{Normalisation, RegressionSettings};
    use super::*;

    #[test]
    fn a_parabola_has_its_second_derivative() {
        let size = Size::new(21, 7);
        let mut scene = Scene::new(size, 0.0);
        scene.features.planes.truncate(1);
        scene.features.groups = std::iter::once(0..1).collect();
        scene.features.planes[0] = (0..147).map(|i| (i % 21) as f32 / 10.0 - 1.0).collect();
        let x = &scene.features.planes[0];
        let channels = [3.0, -1.0, 0.5].map(|a| x.iter().map(|x| a * x * x + x).collect());
        scene.colour = Image::from_channels(size, channels.to_vec());

        let field = Field::new(&scene.input(), 5);
        let settings = RegressionSettings::default();
        let mut window = Window::new(Scalar, &field);
        let mut reduction = Reduction::new(Scalar, &field);
        let mut projection = Projection::new(Scalar, &field);
        let mut curvature = Curvature::new(Scalar, &field);
        for x in [0, 4, 10, 20] {
            window.move_to(&field, x, 3);
            reduction.find(&field, &mut window, Normalisation::None, &settings.reduction);
            projection.find(&field, &window, &reduction, &settings.bandwidth);
            let faint = CurvatureSettings { ridge: 1e-6, ..settings.curvature };
            let (field, window, projection, trust) = (&field, &window, &projection, &window);
            curvature.find(&Neighbours { field, window, projection, rank: 1, trust }, &faint);
            // H is twice the mean of 3, 1 and 0.5.
            let expected = 1.0 / (3.0f32 + 0.16).sqrt();
            let found = curvature.factors[0].to_array()[0];
            assert!((found / expected - 1.0).abs() < 0.01, "at {x}: {found} for {expected}");
        }
    }
}
