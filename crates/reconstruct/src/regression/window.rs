//! The window of a pixel: its neighbours, their features relative to the pixel, and how those are scaled.

use std::ops::Range;

use pulp::Simd;

use super::field::Field;
use super::lanes::{Lanes, MOST_LANES};

stack::knob_choice! {
    /// How features are scaled inside a window before the reduction.
    pub enum Normalisation {
        /// Each group is centred on the window's mean and divided by its largest norm, at least 0.01 (Moon et al. 2014).
        Window = "window",
        /// Not at all.
        None = "none",
    }
}

stack::knobs! {
    /// The window of the regression.
    pub struct WindowSettings("window") {
        /// Radius r of the filtering window of (2r+1)² pixels (section 6: 11 for the final picture, 5 while sampling).
        radius: usize = 11, 1..=31;
        /// Scaling of the features inside a window: `window` or `none`. Equation 13 assumes identity covariance.
        normalise: Normalisation = Normalisation::Window, ..;
    }
}

/// What a neighbour's kernel weight is multiplied by, before a fit looks at it.
pub(crate) trait Trust<S: Simd> {
    /// The factor of the neighbour in row `row` of the window, column `column`; 0 outside the picture.
    fn of(&self, row: usize, column: usize) -> Lanes<S>;

    /// What the weights must sum to more than for a pixel not to be alone: its own factor.
    fn own(&self) -> Lanes<S>;
}

/// All neighbours inside the picture are trusted alike.
impl<S: Simd> Trust<S> for Window<S> {
    #[inline(always)]
    fn of(&self, _row: usize, column: usize) -> Lanes<S> {
        self.inside[column]
    }

    #[inline(always)]
    fn own(&self) -> Lanes<S> {
        Lanes::splat(self.simd, 1.0)
    }
}

/// What features are measured from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// The pixel itself, as in the paper.
    Pixel,
    /// The mean of its window, as in Moon et al. 2014.
    Mean,
}

/// A feature group's norms are divided by no less than this.
const SMALLEST_NORM: f32 = 0.01;
/// A feature that varies by no more than this in a window is constant: what is left is rounding.
const CONSTANT: f32 = 2e-6;

/// The windows of the pixels worked on side by side, clipped at the border of the picture.
#[derive(Debug)]
pub(crate) struct Window<S: Simd> {
    simd: S,
    /// Leftmost of the pixels.
    pub(crate) x: usize,
    /// Their row.
    pub(crate) y: usize,
    /// Rows of the picture in the window.
    pub(crate) rows: Range<usize>,
    /// For each column of the window: 1 where it lies inside the picture, 0 where not.
    pub(crate) inside: Vec<Lanes<S>>,
    /// What each feature's difference to the pixel is multiplied by; 0 where the feature is constant.
    pub(crate) scales: Vec<Lanes<S>>,
    means: Vec<Lanes<S>>,
    ranges: Vec<Lanes<S>>,
    norms: Vec<Lanes<S>>,
    column_sums: Vec<f32>,
    column_minima: Vec<f32>,
    column_maxima: Vec<f32>,
}

impl<S: Simd> Window<S> {
    /// Room for the windows of `field`.
    pub(crate) fn new(simd: S, field: &Field) -> Self {
        let ones = |n| vec![Lanes::splat(simd, 1.0); n];
        let [scales, means, ranges] = [0; 3].map(|_| ones(field.features));
        let [inside, norms] = [0; 2].map(|_| ones(field.columns()));
        let [column_sums, column_minima, column_maxima] = [0; 3].map(|_| vec![0.0; field.columns() + 2 * MOST_LANES]);
        let (x, y, rows) = (0, 0, 0..0);
        Self { simd, x, y, rows, inside, scales, means, ranges, norms, column_sums, column_minima, column_maxima }
    }

    /// Moves to the pixels from `x` on in row `y`.
    #[inline(always)]
    pub(crate) fn move_to(&mut self, field: &Field, x: usize, y: usize) {
        (self.x, self.y) = (x, y);
        self.rows = y.saturating_sub(field.radius)..(y + field.radius + 1).min(field.size.height);
        for (column, inside) in self.inside.iter_mut().enumerate() {
            let mut flags = [0.0; MOST_LANES];
            for (lane, flag) in flags.iter_mut().enumerate() {
                let shifted = x + lane + column;
                let in_picture = shifted >= field.radius && shifted < field.size.width + field.radius;
                *flag = if in_picture && column <= 2 * field.radius { 1.0 } else { 0.0 };
            }
            *inside = Lanes::load(self.simd, &flags);
        }
    }

    /// Finds [`Self::scales`].
    #[inline(always)]
    pub(crate) fn normalise(&mut self, field: &Field, normalisation: Normalisation) {
        let (zero, one) = (Lanes::splat(self.simd, 0.0), Lanes::splat(self.simd, 1.0));
        for group in &field.groups {
            for feature in group.clone() {
                self.find_mean_and_range(field, feature);
            }
            let scale = match normalisation {
                Normalisation::Window => one / self.largest_norm(field, group.clone()),
                Normalisation::None => one,
            };
            for feature in group.clone() {
                let constant = self.ranges[feature].less_than(Lanes::splat(self.simd, CONSTANT));
                self.scales[feature] = constant.select(zero, scale);
            }
        }
    }

    /// Mean of `feature` in the windows, and the difference of its extremes. Columns first, since side by side the
    /// windows share them.
    #[inline(always)]
    fn find_mean_and_range(&mut self, field: &Field, feature: usize) {
        let (columns, lanes) = (2 * field.radius + 1, Lanes::<S>::COUNT);
        for start in (0..columns + lanes - 1).step_by(lanes) {
            let mut sum = Lanes::splat(self.simd, 0.0);
            let (mut least, mut most) = (Lanes::splat(self.simd, f32::MAX), Lanes::splat(self.simd, f32::MIN));
            for y in self.rows.clone() {
                let value = Lanes::load(self.simd, &field.row(feature, self.x, y)[start..]);
                sum += value;
                least = least.min(value);
                most = most.max(value);
            }
            sum.store(&mut self.column_sums[start..]);
            least.store(&mut self.column_minima[start..]);
            most.store(&mut self.column_maxima[start..]);
        }
        let (mut across, mut sum) = (Lanes::splat(self.simd, 0.0), Lanes::splat(self.simd, 0.0));
        let (mut least, mut most) = (Lanes::splat(self.simd, f32::MAX), Lanes::splat(self.simd, f32::MIN));
        for column in 0..columns {
            across += self.inside[column];
            sum += Lanes::load(self.simd, &self.column_sums[column..]) * self.inside[column];
            least = least.min(Lanes::load(self.simd, &self.column_minima[column..]));
            most = most.max(Lanes::load(self.simd, &self.column_maxima[column..]));
        }
        self.means[feature] = sum * (across * self.rows.len() as f32).reciprocal_or_zero();
        self.ranges[feature] = most - least;
    }

    /// Largest norm about the mean of the feature vectors of a `group`, at least [`SMALLEST_NORM`]. The frame repeats
    /// pixels of the window, so it adds none.
    #[inline(always)]
    fn largest_norm(&mut self, field: &Field, group: Range<usize>) -> Lanes<S> {
        let mut largest = Lanes::splat(self.simd, SMALLEST_NORM * SMALLEST_NORM);
        let norms = &mut self.norms[..2 * field.radius + 1];
        for y in self.rows.clone() {
            norms.fill(Lanes::splat(self.simd, 0.0));
            for feature in group.clone() {
                let (row, mean) = (field.row(feature, self.x, y), self.means[feature]);
                for (column, norm) in norms.iter_mut().enumerate() {
                    *norm += (Lanes::load(self.simd, &row[column..]) - mean).squared();
                }
            }
            for norm in norms.iter() {
                largest = largest.max(*norm);
            }
        }
        largest.sqrt()
    }

    /// Writes x_i − x_c, unscaled, of every neighbour i in picture row `y`: one row of `width` numbers for each column
    /// of the window, those of the features listed first and then zeros.
    #[inline(always)]
    pub(crate) fn differences(&self, field: &Field, y: usize, listed: &[usize], width: usize, to: &mut [Lanes<S>]) {
        for (place, feature) in listed.iter().enumerate() {
            let centre = field.at(self.simd, *feature, self.x, self.y);
            let row = field.row(*feature, self.x, y);
            for column in 0..field.columns() {
                to[column * width + place] = Lanes::load(self.simd, &row[column..]) - centre;
            }
        }
        for place in listed.len()..width {
            for column in 0..field.columns() {
                to[column * width + place] = Lanes::splat(self.simd, 0.0);
            }
        }
    }

    /// Writes the matrix D of section 4.3: scaled x_i − x_c (or, from [`Origin::Mean`], x_i less the window's mean) of
    /// every neighbour whose offsets are multiples of `step`, zero outside the picture, in rows of `width` numbers; as many rows as a multiple of 4. Returns how many of the
    /// rows lie inside the picture.
    #[inline(always)]
    pub(crate) fn lattice(
        &self,
        field: &Field,
        (step, origin): (usize, Origin),
        listed: &[usize],
        width: usize,
        to: &mut Vec<Lanes<S>>,
    ) -> Lanes<S> {
        let zero = Lanes::splat(self.simd, 0.0);
        let reach = field.radius - field.radius % step;
        to.clear();
        let (mut across, mut down) = (zero, 0);
        for column in (field.radius - reach..=field.radius + reach).step_by(step) {
            across += self.inside[column];
        }
        for y in self.rows.clone().filter(|y| y.abs_diff(self.y) % step == 0) {
            down += 1;
            for column in (field.radius - reach..=field.radius + reach).step_by(step) {
                for feature in listed {
                    let centre = match origin {
                        Origin::Pixel => field.at(self.simd, *feature, self.x, self.y),
                        Origin::Mean => self.means[*feature],
                    };
                    let value = Lanes::load(self.simd, &field.row(*feature, self.x, y)[column..]);
                    to.push((value - centre) * self.scales[*feature] * self.inside[column]);
                }
                to.resize(to.len() + width - listed.len(), zero);
            }
        }
        to.resize(to.len().next_multiple_of(4 * width), zero);
        across * down as f32
    }
}

#[cfg(test)]
mod tests {
    use pulp::{Scalar, Scalar256b};
    use stack::{Image, Size};

    use super::super::RegressionInput;
    use super::super::twin::Scene;
    use super::*;
    use crate::prefilter::FeatureSet;

    /// Three pixels in a row; a group of two features, a faint one, and one that is constant.
    fn row_of_three() -> (Image, FeatureSet) {
        let size = Size::new(3, 1);
        let planes = vec![vec![0.0, 0.3, 0.6], vec![0.4, 0.4, 1.0], vec![0.0, 1e-3, 0.0], vec![0.7; 3]];
        (Image::zeros(size, 3), FeatureSet { size, planes, groups: vec![0..2, 2..3, 3..4] })
    }

    #[test]
    fn scales_by_hand() {
        let (black, features) = row_of_three();
        let input = RegressionInput { colour: &black, variance: &black, features: &features, active: None };
        let field = Field::new(&input, 2);
        let mut window = Window::new(Scalar, &field);
        let mut scales_at = |x, normalisation| {
            window.move_to(&field, x, 0);
            window.normalise(&field, normalisation);
            [0, 1, 2, 3].map(|f| window.scales[f].to_array()[0])
        };
        // Means 0.3 and 0.6; the last pixel is farthest: (0.3, 0.4).
        for x in 0..3 {
            let scales = scales_at(x, Normalisation::Window);
            assert!((scales[0] - 2.0).abs() < 1e-5 && scales[1] == scales[0], "{scales:?}");
            assert_eq!(scales[2..], [1.0 / 0.01, 0.0]);
        }
        assert_eq!(scales_at(1, Normalisation::None), [1.0, 1.0, 1.0, 0.0]);
    }

    #[test]
    fn the_lattice_holds_scaled_differences_within_the_picture() {
        let (black, features) = row_of_three();
        let input = RegressionInput { colour: &black, variance: &black, features: &features, active: None };
        let field = Field::new(&input, 2);
        let mut window = Window::new(Scalar, &field);
        window.move_to(&field, 2, 0);
        window.normalise(&field, Normalisation::None);
        let mut rows = vec![];
        let inside = window.lattice(&field, (2, Origin::Pixel), &[0, 1], 2, &mut rows);
        assert_eq!(inside.to_array()[0], 2.0);
        // Offsets −2, 0 and 2, the last of which is outside, and a row of padding.
        let values: Vec<f32> = rows.iter().map(|v| v.to_array()[0]).collect();
        let expected = [-0.6, -0.6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert!(values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{values:?}");
    }

    #[test]
    fn each_lane_sees_its_own_window() {
        let scene = Scene::new(Size::new(21, 9), 0.0);
        let field = Field::new(&scene.input(), 5);
        let (mut wide, mut single) = (Window::new(Scalar256b, &field), Window::new(Scalar, &field));
        for (start, y) in [(0, 0), (8, 4), (16, 8)] {
            wide.move_to(&field, start, y);
            wide.normalise(&field, Normalisation::Window);
            for x in start..(start + 8).min(21) {
                single.move_to(&field, x, y);
                single.normalise(&field, Normalisation::Window);
                for (a, b) in wide.scales.iter().zip(&single.scales) {
                    assert_eq!(a.to_array()[x - start], b.to_array()[0]);
                }
            }
        }
    }
}
