//! The error of a mixture, and how it follows the chooser's parameters.

use super::answer::{Answer, Judged};
use crate::best::choice::chooser::{Chooser, PARAMETERS, softmax};
use crate::best::choice::evidence::CANDIDATES;
use crate::best::choice::inputs::{Block, LANES, Lanes};
use crate::network::sum_of_lanes;

/// An error this many times the size of the rule's pulls half as hard as it would: a few pixels should not rule the rest.
const FAR: f32 = 30.0;
/// Share of pixels that are left out of the rule's mean.
const WORST: f64 = 1e-3;
/// Least mean error of the rule.
const LEAST_NORM: f32 = 1e-7;

/// Error and its derivatives, mean over pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Slope {
    /// (x − r₁)(x − r₂)/(r² + 0.001) for a mixture x and references r₁ and r₂, r their mean: as references are
    /// independent, its mean is that of (x − truth)². Mean over channels, relative to the size of
    /// the rule's.
    pub error: f64,
    /// Its derivative by each parameter.
    pub gradient: Vec<f64>,
}

impl Slope {
    /// No error yet.
    pub fn nothing() -> Self {
        Self { error: 0.0, gradient: vec![0.0; PARAMETERS] }
    }

    /// Adds `share` of another.
    pub fn add(&mut self, other: &Self, share: f64) {
        self.error += share * other.error;
        self.gradient.iter_mut().zip(&other.gradient).for_each(|(sum, g)| *sum += share * g);
    }
}

/// Adds error and slope of a block's pixels to `sum`.
#[inline(always)]
pub(super) fn slope_of_block(judged: &Judged, chooser: &Chooser, sum: &mut Slope) {
    let Judged { block, answer, norm } = *judged;
    let at = chooser.activate(block);
    let mixed = mixed(answer, &at.weights);
    let errors = errors(answer, &mixed);
    let mut pull = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        let error = errors[lane] / norm;
        let share = 1.0 / (3.0 * LANES as f32 * norm * (1.0 + error.abs() / FAR));
        for c in 0..3 {
            let off = 2.0 * mixed[c][lane] - answer.truth[0][c][lane] - answer.truth[1][c][lane];
            pull[c][lane] = share * off / answer.scale[c][lane];
        }
    }
    let mut slope = [[0.0; LANES]; CANDIDATES];
    for (slope, candidate) in slope.iter_mut().zip(&answer.candidates) {
        for c in 0..3 {
            (0..LANES).for_each(|lane| slope[lane] += pull[c][lane] * candidate[c][lane]);
        }
    }
    sum.error += f64::from(sum_of_lanes(errors) / (LANES as f32 * norm));
    chooser.add_gradient(&at, &slope, &mut sum.gradient);
}

#[inline(always)]
fn mixed(answer: &Answer, weights: &[Lanes; CANDIDATES]) -> [Lanes; 3] {
    let mut mixed = [[0.0; LANES]; 3];
    for (weight, candidate) in weights.iter().zip(&answer.candidates) {
        for c in 0..3 {
            (0..LANES).for_each(|lane| mixed[c][lane] += weight[lane] * candidate[c][lane]);
        }
    }
    mixed
}

/// Errors of a mixture, mean over channels.
#[inline(always)]
fn errors(answer: &Answer, mixed: &[Lanes; 3]) -> Lanes {
    let mut errors = [0.0; LANES];
    for c in 0..3 {
        for lane in 0..LANES {
            let [first, second] = [0, 1].map(|which: usize| mixed[c][lane] - answer.truth[which][c][lane]);
            errors[lane] += first * second / (3.0 * answer.scale[c][lane]);
        }
    }
    errors
}

/// Errors of all pixels with the rule's weights.
pub(super) fn errors_of_rule(blocks: &[Block], answers: &[Answer]) -> Vec<f32> {
    let of_rule = |(block, answer): (&Block, &Answer)| errors(answer, &mixed(answer, &softmax(block.rule)));
    blocks.iter().zip(answers).flat_map(of_rule).collect()
}

/// Their mean size without the largest, above 0. The size, because noisy references make errors of either sign: a picture
/// whose references say little should not count for much.
pub(super) fn norm_of(mut errors: Vec<f32>) -> f32 {
    errors.iter_mut().for_each(|error| *error = error.abs());
    errors.sort_by(f32::total_cmp);
    let kept = errors.len() - (WORST * errors.len() as f64).ceil() as usize;
    let sum = errors[..kept].iter().map(|v| f64::from(*v)).sum::<f64>();
    ((sum / kept.max(1) as f64) as f32).max(LEAST_NORM)
}
