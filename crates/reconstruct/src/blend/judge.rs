//! The network that says how far to follow the other picture: one hidden layer, the nodes of several networks side by side.

use rayon::prelude::*;

use super::inputs::{INPUTS, Inputs};
use crate::exp::exp_of_negative;
use crate::network::{lanes_of, tanh, weighted_sum};

/// Nodes of the hidden layer: those of four networks of 24, whose logits are averaged by the weights of the output. Where a
/// picture is like none that they learned from, they err in different directions.
pub const HIDDEN: usize = 96;
/// Numbers of a hidden node: its bias, its weights.
pub const NODE: usize = 1 + INPUTS;
/// Inputs are cut off this many deviations from their mean: further out, nothing was learned.
pub const FURTHEST: f32 = 3.0;

/// Pixels that are worked on at once.
const LANES: usize = 16;
/// A value of each of them.
type Lanes = [f32; LANES];

/// The network, with what it needs to know about its inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Judge {
    /// Mean of each input over the training set.
    pub means: [f32; INPUTS],
    /// Standard deviation of each.
    pub deviations: [f32; INPUTS],
    /// The hidden nodes, [`NODE`] numbers each.
    pub hidden: Vec<f32>,
    /// Bias of the output, then its weights.
    pub output: [f32; 1 + HIDDEN],
}

impl Judge {
    /// The weight of the other picture at every pixel, 0 to 1: the logistic function of s + b + Σ w h, h = tanh(b + Σ w x), with
    /// what is at stake there, s.
    pub fn weights(&self, inputs: &Inputs, stakes: &[f32]) -> Vec<f32> {
        let pixels = inputs.pixels();
        let weighed = |at| pulp::Arch::new().dispatch(BlockTask { judge: self, inputs, stakes, at });
        let blocks: Vec<Lanes> = lanes_of(pixels).map(weighed).collect();
        blocks.into_iter().flatten().take(pixels).collect()
    }

    #[inline(always)]
    fn activate(&self, block: &[Lanes; INPUTS], stakes: &Lanes) -> Lanes {
        let mut hidden = [[0.0; LANES]; HIDDEN];
        for (value, node) in hidden.iter_mut().zip(self.hidden.chunks_exact(NODE)) {
            *value = weighted_sum([node[0]; LANES], &node[1..], block).map(tanh);
        }
        weighted_sum(stakes.map(|stake| stake + self.output[0]), &self.output[1..], &hidden).map(logistic)
    }
}

/// Some pixels, with the widest instructions there are.
struct BlockTask<'a> {
    judge: &'a Judge,
    inputs: &'a Inputs<'a>,
    stakes: &'a [f32],
    at: [usize; LANES],
}

impl pulp::NullaryFnOnce for BlockTask<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn call(self) -> Lanes {
        let Self { judge, inputs, stakes, at } = self;
        let mut block = [[0.0; LANES]; INPUTS];
        for (lane, pixel) in at.into_iter().enumerate() {
            for (i, value) in inputs.at(pixel).into_iter().enumerate() {
                let standard = (value - judge.means[i]) / judge.deviations[i];
                block[i][lane] = standard.clamp(-FURTHEST, FURTHEST);
            }
        }
        judge.activate(&block, &at.map(|pixel| stakes[pixel]))
    }
}

/// 1/(1 + e⁻ˣ).
fn logistic(x: f32) -> f32 {
    let e = exp_of_negative(-x.abs());
    (if x < 0.0 { e } else { 1.0 }) / (1.0 + e)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logistic_function_is_its_formula() {
        for x in [-30.0, -2.0, -0.1, 0.0, 0.7, 5.0, 40.0] {
            let expected = 1.0 / (1.0 + (-f64::from(x)).exp());
            assert!((f64::from(logistic(x)) - expected).abs() < 1e-6, "{x}");
        }
    }

    #[test]
    fn a_node_is_the_tangent_of_its_sum() {
        let mut hidden = vec![0.0; HIDDEN * NODE];
        // The second node looks at the first and the last input.
        (hidden[NODE], hidden[NODE + 1], hidden[2 * NODE - 1]) = (0.3, 0.5, -0.25);
        let mut output = [0.0; 1 + HIDDEN];
        (output[0], output[2]) = (-1.0, 2.0);
        let judge = Judge { means: [0.0; INPUTS], deviations: [1.0; INPUTS], hidden, output };
        let mut block = [[7.0; LANES]; INPUTS];
        (block[0], block[INPUTS - 1]) = ([1.0; LANES], [2.0; LANES]);
        let expected = 1.0 / (1.0 + (0.5 - 2.0 * 0.3_f64.tanh()).exp());
        assert!((f64::from(judge.activate(&block, &[0.5; LANES])[5]) - expected).abs() < 1e-6);
    }
}
