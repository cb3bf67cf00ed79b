//! How fast the picture bends along each reduced direction, and the bandwidth factors that follow (section 3.1).

use pulp::Simd;

use super::bandwidth::Projection;
use super::cholesky::{factor, substitute_back};
use super::field::Field;
use super::lanes::Lanes;
use super::matrix::add_gram;
use super::window::Window;

stack::knobs! {
    /// The bandwidth factors b_j (section 3.1, after Moon et al. 2014).
    pub struct CurvatureSettings("curvature") {
        /// Ridge of the quadratic fit, as a share of the kernel's weight.
        ridge: f32 = 1e-3, 1e-6..=1.0;
        /// Added to the second derivative |H_j| in b_j = 1/√(|H_j| + floor).
        floor: f32 = 0.16, 1e-4..=100.0;
    }
}

/// Rows gathered before they are added to the normal equations.
const BLOCK: usize = 16;

/// The quadratic fit of the pixels worked on side by side, and the room to make it in.
#[derive(Debug)]
pub(crate) struct Curvature<S: Simd> {
    simd: S,
    /// b_j of each reduced direction.
    pub(crate) factors: Vec<Lanes<S>>,
    rows: Vec<Lanes<S>>,
    normal: Vec<Lanes<S>>,
}

impl<S: Simd> Curvature<S> {
    /// Room for the windows of `field`.
    pub(crate) fn new(simd: S, field: &Field) -> Self {
        let zeros = |n| vec![Lanes::splat(simd, 0.0); n];
        let most = field.features.next_multiple_of(2).max(2);
        let width = 2 * most + 4;
        Self { simd, factors: zeros(most), rows: Vec::with_capacity(BLOCK * width), normal: zeros(width * width) }
    }

    /// Fits 1, z_j and z_j² (j < `rank`) to each colour channel with a kernel of bandwidth 1, H_j being twice the mean
    /// size of the coefficients of z_j².
    #[inline(always)]
    pub(crate) fn find(
        &mut self,
        field: &Field,
        window: &Window<S>,
        projection: &Projection<S>,
        rank: usize,
        settings: &CurvatureSettings,
    ) {
        let (unknowns, width) = (2 * rank + 1, 2 * rank + 4);
        self.add_neighbours(field, window, projection, rank);
        let ridge = self.normal[0] * settings.ridge;
        for i in 0..unknowns {
            self.normal[i * width + i] += ridge;
        }
        factor(self.simd, &mut self.normal[..unknowns * width], unknowns, width, ridge);
        for channel in 0..3 {
            substitute_back(&mut self.normal, unknowns, width, unknowns + channel, rank + 1);
        }
        for j in 0..rank {
            let coefficients = &self.normal[(rank + 1 + j) * width + unknowns..][..3];
            let sum = coefficients[0].abs() + coefficients[1].abs() + coefficients[2].abs();
            let second_derivative = sum * (2.0 / 3.0);
            self.factors[j] = Lanes::splat(self.simd, 1.0) / (second_derivative + settings.floor).sqrt();
        }
    }

    /// The normal equations, colours in the last three columns.
    #[inline(always)]
    fn add_neighbours(&mut self, field: &Field, window: &Window<S>, projection: &Projection<S>, rank: usize) {
        let width = 2 * rank + 4;
        let zero = Lanes::splat(self.simd, 0.0);
        self.normal[..width * width].fill(zero);
        self.rows.clear();
        let centre = [0, 1, 2].map(|c| field.at(self.simd, field.colour(c), window.x, window.y));
        for (row, y) in window.rows.clone().enumerate() {
            let colour = [0, 1, 2].map(|c| field.row(field.colour(c), window.x, y));
            for (column, inside) in window.inside.iter().enumerate() {
                let z = projection.of(row * field.columns() + column);
                let mut weight = *inside;
                for j in 0..rank {
                    weight = weight * (Lanes::splat(self.simd, 1.0) - z[j].squared()).positive_part();
                }
                if !zero.less_than(weight).any() {
                    continue;
                }
                let root = weight.sqrt();
                self.push_row(root, &z[..rank]);
                for c in 0..3 {
                    self.rows.push(root * (Lanes::load(self.simd, &colour[c][column..]) - centre[c]));
                }
                if self.rows.len() == BLOCK * width {
                    self.add_rows(width);
                }
            }
        }
        self.add_rows(width);
    }

    #[inline(always)]
    fn push_row(&mut self, root: Lanes<S>, z: &[Lanes<S>]) {
        self.rows.push(root);
        for z in z {
            self.rows.push(root * *z);
        }
        for z in z {
            self.rows.push(root * z.squared());
        }
    }

    #[inline(always)]
    fn add_rows(&mut self, width: usize) {
        add_gram(self.simd, &mut self.normal[..width * width], &self.rows, width);
        self.rows.clear();
    }
}
