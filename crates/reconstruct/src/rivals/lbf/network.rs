//! The network that chooses bandwidths: one hidden layer (the paper's section 4.1).

use super::kernel::{Bandwidths, TERMS};
use super::secondary::{INPUTS, Inputs};
use crate::exp::exp_of_negative;

/// Nodes of the hidden layer.
pub const HIDDEN: usize = 16;
/// Numbers the training may change: weights and biases of both layers.
pub const PARAMETERS: usize = HIDDEN * (INPUTS + 1) + TERMS * (HIDDEN + 1);

/// Inputs are cut off this many deviations from their mean: further out, nothing was learned.
const FURTHEST: f32 = 3.0;
/// No bandwidth is less than this many units.
const LEAST: f32 = 0.02;

/// A network with what it needs to know about its inputs and outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    /// Mean of each input over the training set.
    pub means: Inputs,
    /// Standard deviation of each input.
    pub deviations: Inputs,
    /// What each bandwidth is measured in.
    pub units: Bandwidths,
    /// For each hidden node its bias and weights, then for each output the same.
    pub parameters: Vec<f32>,
}

/// What a pixel's values were on the way to its bandwidths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Activation {
    inputs: Inputs,
    hidden: [f32; HIDDEN],
    outputs: [f32; TERMS],
    /// The result.
    pub(super) bandwidths: Bandwidths,
}

impl Network {
    /// The bandwidths of a pixel with these secondary features.
    pub fn bandwidths(&self, secondary: &Inputs) -> Bandwidths {
        self.activate(secondary).bandwidths
    }

    /// Hidden nodes are tanh(b + Σ w x), outputs b + Σ w h, bandwidths units·(softplus(output) + a least value).
    pub(super) fn activate(&self, secondary: &Inputs) -> Activation {
        let normal = |i: usize| ((secondary[i] - self.means[i]) / self.deviations[i]).clamp(-FURTHEST, FURTHEST);
        let inputs: Inputs = std::array::from_fn(normal);
        let (first, second) = self.parameters.split_at(HIDDEN * (INPUTS + 1));
        let hidden: [f32; HIDDEN] = std::array::from_fn(|n| tanh(node(first, n, &inputs)));
        let outputs: [f32; TERMS] = std::array::from_fn(|n| node(second, n, &hidden));
        let bandwidths = std::array::from_fn(|t| self.units[t] * (LEAST + softplus(outputs[t])));
        Activation { inputs, hidden, outputs, bandwidths }
    }

    /// Adds dE/dparameter to `gradient`, from `slope`, the pixel's dE/dbandwidth.
    pub(super) fn add_gradient(&self, at: &Activation, slope: &Bandwidths, gradient: &mut [f64]) {
        let (first, second) = gradient.split_at_mut(HIDDEN * (INPUTS + 1));
        let weights = &self.parameters[HIDDEN * (INPUTS + 1)..];
        let mut back = [0.0; HIDDEN];
        for term in 0..TERMS {
            let slope = slope[term] * self.units[term] * sigmoid(at.outputs[term]);
            add_node(&mut second[term * (HIDDEN + 1)..][..HIDDEN + 1], &at.hidden, slope);
            let weights = &weights[term * (HIDDEN + 1) + 1..][..HIDDEN];
            back.iter_mut().zip(weights).for_each(|(back, weight)| *back += slope * weight);
        }
        for n in 0..HIDDEN {
            let slope = back[n] * (1.0 - at.hidden[n] * at.hidden[n]);
            add_node(&mut first[n * (INPUTS + 1)..][..INPUTS + 1], &at.inputs, slope);
        }
    }
}

/// Bias and weighted sum of node `n` of a layer.
fn node(layer: &[f32], n: usize, inputs: &[f32]) -> f32 {
    let own = &layer[n * (inputs.len() + 1)..][..inputs.len() + 1];
    own[1..].iter().zip(inputs).fold(own[0], |sum, (weight, input)| sum + weight * input)
}

fn add_node(gradient: &mut [f64], inputs: &[f32], slope: f32) {
    gradient[0] += f64::from(slope);
    gradient[1..].iter_mut().zip(inputs).for_each(|(sum, input)| *sum += f64::from(slope * input));
}

fn tanh(x: f32) -> f32 {
    let e = exp_of_negative(-2.0 * x.abs());
    ((1.0 - e) / (1.0 + e)).copysign(x)
}

fn sigmoid(x: f32) -> f32 {
    let e = exp_of_negative(-x.abs());
    if x >= 0.0 { 1.0 / (1.0 + e) } else { e / (1.0 + e) }
}

/// ln(1 + eˣ), above 0.
fn softplus(x: f32) -> f32 {
    x.max(0.0) + exp_of_negative(-x.abs()).ln_1p()
}

/// The output whose bandwidth is one unit.
pub(super) fn output_of_unit() -> f32 {
    (1.0 - LEAST).exp_m1().ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A network whose first hidden node sees the first input only and acts on the first bandwidth only.
    fn simple() -> Network {
        let mut parameters = vec![0.0; PARAMETERS];
        (parameters[0], parameters[1]) = (0.25, 0.5);
        let outputs = HIDDEN * (INPUTS + 1);
        (parameters[outputs], parameters[outputs + 1]) = (0.1, 2.0);
        Network { means: [1.0; INPUTS], deviations: [2.0; INPUTS], units: [3.0; TERMS], parameters }
    }

    #[test]
    fn values_are_those_of_the_formula() {
        let mut inputs = [0.0; INPUTS];
        inputs[0] = 4.0;
        let found = simple().bandwidths(&inputs);
        let hidden = (0.25_f64 + 0.5 * 1.5).tanh();
        let expected = 3.0 * (0.02 + (1.0 + (0.1 + 2.0 * hidden).exp()).ln());
        assert!((f64::from(found[0]) - expected).abs() < 1e-5, "{} {expected}", found[0]);
        assert!((f64::from(found[1]) - 3.0 * (0.02 + 2.0_f64.ln())).abs() < 1e-5);
        inputs[0] = 1e9;
        let cut = simple().bandwidths(&inputs);
        inputs[0] = 1.0 + 2.0 * FURTHEST;
        assert_eq!(cut, simple().bandwidths(&inputs));
    }

    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        let mut network = simple();
        let mut numbers = crate::test_noise::TestNoise(5);
        network.parameters = numbers.normals(PARAMETERS, 0.0, 0.3);
        let inputs: Inputs = std::array::from_fn(|i| (i as f32 * 0.7).sin());
        let pull = [1.0, -2.0, 0.5, 1.0, 0.0, 3.0];
        let mut gradient = vec![0.0; PARAMETERS];
        network.add_gradient(&network.activate(&inputs), &pull, &mut gradient);
        for i in (0..PARAMETERS).step_by(7) {
            let mut error = |change: f32| -> f64 {
                let kept = network.parameters[i];
                network.parameters[i] = kept + change;
                let found = network.bandwidths(&inputs);
                network.parameters[i] = kept;
                found.iter().zip(pull).map(|(b, pull)| f64::from(b * pull)).sum()
            };
            let expected = (error(1e-2) - error(-1e-2)) / 2e-2;
            assert!((gradient[i] - expected).abs() < 2e-3 * (1.0 + expected.abs()), "{i}: {} {expected}", gradient[i]);
        }
    }
}
