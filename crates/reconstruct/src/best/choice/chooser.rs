//! The network that scores candidates: one hidden layer, the same for all candidates but for its biases.

use super::evidence::CANDIDATES;
use super::inputs::{Block, LANES, Lanes, OWN, SHARED};
use crate::exp::exp_of_negative;
use crate::network::{add_products, sum_of_lanes, tanh, weighted_sum};

/// Nodes of the hidden layer.
pub const HIDDEN: usize = 24;
/// Inputs of a node.
pub const INPUTS: usize = OWN + SHARED;
/// Numbers of a hidden node: a bias for each candidate, weights of what candidates share, weights of their own.
pub const NODE: usize = CANDIDATES + SHARED + OWN;
/// Numbers the training may change: hidden nodes, weights of the output.
pub const PARAMETERS: usize = HIDDEN * (NODE + 1);

/// Inputs are cut off this many deviations from their mean: further out, nothing was learned.
const FURTHEST: f32 = 4.0;

/// A network that scores candidates, with what it needs to know about its inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Chooser {
    /// Mean of each input over the training set: a candidate's own, then the shared ones.
    pub(super) means: [f32; INPUTS],
    /// Standard deviation of each input.
    pub(super) deviations: [f32; INPUTS],
    /// The hidden nodes, [`NODE`] numbers each, then the weights of the output.
    pub(super) parameters: Vec<f32>,
}

/// What a block's values were on the way to its weights.
pub(super) struct Activation {
    block: Block,
    hidden: [[Lanes; HIDDEN]; CANDIDATES],
    /// The result.
    pub(super) weights: [Lanes; CANDIDATES],
}

impl Chooser {
    /// What each candidate weighs at the pixels of `block`: the softmax of the rule's score plus Σ w h of hidden nodes
    /// h = tanh(b + Σ w x). They add up to 1.
    #[inline(always)]
    pub(super) fn weights(&self, block: &Block) -> [Lanes; CANDIDATES] {
        self.activate(block).weights
    }

    #[inline(always)]
    pub(super) fn activate(&self, block: &Block) -> Activation {
        let mut block = *block;
        self.standardise(&mut block);
        let output = &self.parameters[HIDDEN * NODE..];
        let mut hidden = [[[0.0; LANES]; HIDDEN]; CANDIDATES];
        for (n, node) in self.parameters[..HIDDEN * NODE].chunks_exact(NODE).enumerate() {
            let (biases, weights) = node.split_at(CANDIDATES);
            let (of_shared, of_own) = weights.split_at(SHARED);
            let shared = weighted_sum([0.0; LANES], of_shared, &block.shared);
            for k in 0..CANDIDATES {
                let sum = weighted_sum(shared, of_own, &block.own[k]);
                for lane in 0..LANES {
                    hidden[k][n][lane] = tanh(biases[k] + sum[lane]);
                }
            }
        }
        let mut scores = block.rule;
        for (score, hidden) in scores.iter_mut().zip(&hidden) {
            *score = weighted_sum(*score, output, hidden);
        }
        Activation { block, hidden, weights: softmax(scores) }
    }

    #[inline(always)]
    fn standardise(&self, block: &mut Block) {
        for k in 0..CANDIDATES {
            for i in 0..OWN {
                self.standardise_input(i, &mut block.own[k][i]);
            }
        }
        for i in 0..SHARED {
            self.standardise_input(OWN + i, &mut block.shared[i]);
        }
    }

    #[inline(always)]
    fn standardise_input(&self, input: usize, lanes: &mut Lanes) {
        let (mean, scale) = (self.means[input], 1.0 / self.deviations[input]);
        for value in lanes {
            *value = ((*value - mean) * scale).clamp(-FURTHEST, FURTHEST);
        }
    }

    /// Adds dE/dparameter to `gradient`, from `slope`, the block's dE/dweight of every candidate.
    #[inline(always)]
    pub(super) fn add_gradient(&self, at: &Activation, slope: &[Lanes; CANDIDATES], gradient: &mut [f64]) {
        let scores = softmax_slope(&at.weights, slope);
        let (nodes, output) = gradient.split_at_mut(HIDDEN * NODE);
        for (n, node) in nodes.chunks_exact_mut(NODE).enumerate() {
            let weight = self.parameters[HIDDEN * NODE + n];
            let (biases, weights) = node.split_at_mut(CANDIDATES);
            let (of_shared, of_own) = weights.split_at_mut(SHARED);
            let mut shared = [0.0; LANES];
            for k in 0..CANDIDATES {
                let mut back = [0.0; LANES];
                for lane in 0..LANES {
                    let h = at.hidden[k][n][lane];
                    back[lane] = scores[k][lane] * weight * (1.0 - h * h);
                    shared[lane] += back[lane];
                }
                biases[k] += f64::from(sum_of_lanes(back));
                add_products(of_own, &back, &at.block.own[k]);
            }
            add_products(of_shared, &shared, &at.block.shared);
        }
        for (scores, hidden) in scores.iter().zip(&at.hidden) {
            add_products(output, scores, hidden);
        }
    }
}

/// Weights that rise exponentially with `scores` and add up to 1.
#[inline(always)]
pub(super) fn softmax<const N: usize>(scores: [Lanes; N]) -> [Lanes; N] {
    let (mut most, mut total) = ([f32::NEG_INFINITY; LANES], [0.0; LANES]);
    for score in &scores {
        (0..LANES).for_each(|lane| most[lane] = most[lane].max(score[lane]));
    }
    let mut weights = scores;
    for weight in &mut weights {
        for lane in 0..LANES {
            weight[lane] = exp_of_negative(weight[lane] - most[lane]);
            total[lane] += weight[lane];
        }
    }
    for weight in &mut weights {
        (0..LANES).for_each(|lane| weight[lane] /= total[lane]);
    }
    weights
}

/// dE/dscore = w (dE/dw − Σ w dE/dw).
#[inline(always)]
fn softmax_slope(weights: &[Lanes; CANDIDATES], slope: &[Lanes; CANDIDATES]) -> [Lanes; CANDIDATES] {
    let mut mean = [0.0; LANES];
    for (weight, slope) in weights.iter().zip(slope) {
        (0..LANES).for_each(|lane| mean[lane] += weight[lane] * slope[lane]);
    }
    let mut scores = *slope;
    for (score, weight) in scores.iter_mut().zip(weights) {
        (0..LANES).for_each(|lane| score[lane] = weight[lane] * (score[lane] - mean[lane]));
    }
    scores
}
