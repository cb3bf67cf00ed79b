//! The window of a pixel: its neighbours, their features relative to the pixel, and how those are scaled.

use std::ops::Range;

use pulp::Simd;

use super::field::Field;
use super::lanes::Lanes;

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
}

impl<S: Simd> Window<S> {
    /// Room for the windows of `field`.
    pub(crate) fn new(simd: S, field: &Field) -> Self {
        let ones = |n| vec![Lanes::splat(simd, 1.0); n];
        let (inside, scales, means) = (ones(field.columns()), ones(field.features), ones(field.features));
        Self { simd, x: 0, y: 0, rows: 0..0, inside, scales, means }
    }

    /// Moves to the pixels from `x` on in row `y`.
    #[inline(always)]
    pub(crate) fn move_to(&mut self, field: &Field, x: usize, y: usize) {
        (self.x, self.y) = (x, y);
        self.rows = y.saturating_sub(field.radius)..(y + field.radius + 1).min(field.size.height);
        for (column, inside) in self.inside.iter_mut().enumerate() {
            let mut flags = [0.0; super::lanes::MOST_LANES];
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
        self.find_means(field);
        for group in &field.groups {
            let largest = self.largest_norm(field, group.clone());
            for feature in group.clone() {
                let scale = match normalisation {
                    Normalisation::Window => Lanes::splat(self.simd, 1.0) / largest,
                    Normalisation::None => Lanes::splat(self.simd, 1.0),
                };
                let constant = self.scales[feature].less_than(Lanes::splat(self.simd, CONSTANT));
                self.scales[feature] = constant.select(Lanes::splat(self.simd, 0.0), scale);
            }
        }
    }

    /// Mean of every feature. The frame of the field is zero, so it adds nothing.
    #[inline(always)]
    fn find_means(&mut self, field: &Field) {
        let mut across = Lanes::splat(self.simd, 0.0);
        for inside in &self.inside {
            across += *inside;
        }
        let share = (across * self.rows.len() as f32).reciprocal_or_zero();
        for feature in 0..field.features {
            let mut sum = Lanes::splat(self.simd, 0.0);
            for y in self.rows.clone() {
                let row = field.row(feature, self.x, y);
                for column in 0..2 * field.radius + 1 {
                    sum += Lanes::load(self.simd, &row[column..]);
                }
            }
            self.means[feature] = sum * share;
        }
    }

    /// Largest norm about the mean of the feature vectors of a `group`, at least [`SMALLEST_NORM`]. Leaves the largest
    /// deviation of each feature in `scales`.
    #[inline(always)]
    fn largest_norm(&mut self, field: &Field, group: Range<usize>) -> Lanes<S> {
        let mut largest = Lanes::splat(self.simd, SMALLEST_NORM * SMALLEST_NORM);
        for feature in group.clone() {
            self.scales[feature] = Lanes::splat(self.simd, 0.0);
        }
        for y in self.rows.clone() {
            for (column, inside) in self.inside.iter().enumerate() {
                let mut norm = Lanes::splat(self.simd, 0.0);
                for feature in group.clone() {
                    let value = Lanes::load(self.simd, &field.row(feature, self.x, y)[column..]);
                    let deviation = (value - self.means[feature]) * *inside;
                    self.scales[feature] = self.scales[feature].max(deviation.abs());
                    norm += deviation.squared();
                }
                largest = largest.max(norm);
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

    /// Writes the matrix D of section 4.3: scaled x_i − x_c of every neighbour whose offsets are multiples of `step`,
    /// zero outside the picture, in rows of `width` numbers; as many rows as a multiple of 4. Returns how many of the
    /// rows lie inside the picture.
    #[inline(always)]
    pub(crate) fn lattice(
        &self,
        field: &Field,
        step: usize,
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
                    let centre = field.at(self.simd, *feature, self.x, self.y);
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
