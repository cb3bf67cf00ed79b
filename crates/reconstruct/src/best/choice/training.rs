//! Training of the chooser: its weights, through the mixture, by the error of the mixed picture against two independent
//! references.

mod answer;
mod example;
mod lights;
mod slope;

use rayon::prelude::*;
use stack::{Cancelled, Monitor};

use super::chooser::{Chooser, HIDDEN, INPUTS, NODE, PARAMETERS};
use super::evidence::CANDIDATES;
use super::inputs::{Block, OWN};
use crate::network::{Adam, Numbers};
use answer::Judged;
pub use example::Example;
use slope::{Slope, slope_of_block};

/// How the network is trained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingSettings {
    /// Steps along the gradient.
    pub steps: usize,
    /// Blocks of 16 pixels of every example whose gradient makes one step.
    pub blocks: usize,
    /// Length of the first step; it falls to a twentieth along a straight line.
    pub rate: f64,
    /// What a weight's square is held to cost against the error: small ones that do no harm are kept small.
    pub decay: f64,
    /// Seed of the first weights.
    pub seed: u64,
}

/// Trains a chooser that begins as the rule. The result depends on nothing but the arguments. Reports one unit per step
/// as stage `training`, and notes the mean error, relative to the rule's, of every fiftieth.
///
/// # Errors
/// When `monitor` cancels.
pub fn train(examples: &[Example], settings: &TrainingSettings, monitor: &dyn Monitor) -> Result<Chooser, Cancelled> {
    let mut chooser = start(examples, settings.seed);
    let mut adam = Adam::new(PARAMETERS);
    monitor.begin("training", settings.steps as u64);
    for step in 0..settings.steps {
        if monitor.cancelled() {
            return Err(Cancelled);
        }
        let mut slope = mean_slope(examples, &chooser, step * settings.blocks, settings.blocks);
        let pull = slope.gradient.iter_mut().zip(&chooser.parameters);
        pull.for_each(|(gradient, parameter)| *gradient += settings.decay * f64::from(*parameter));
        let rate = settings.rate * (1.0 - 0.95 * step as f64 / settings.steps as f64);
        adam.step(&mut chooser.parameters, &slope.gradient, rate);
        if (step + 1) % 50 == 0 {
            monitor.note(&format!("step {}: error {:.4} of the rule's", step + 1, slope.error));
        }
        monitor.advance(1);
    }
    Ok(chooser)
}

/// Mean over examples, of `count` blocks each from the `first` on, round and round.
fn mean_slope(examples: &[Example], chooser: &Chooser, first: usize, count: usize) -> Slope {
    let of_example = |example: &Example| {
        let mut sum = Slope::nothing();
        for block in first..first + count {
            pulp::Arch::new().dispatch(BlockTask { judged: example.judged(block), chooser, sum: &mut sum });
        }
        sum
    };
    let slopes: Vec<Slope> = examples.par_iter().map(of_example).collect();
    let mut mean = Slope::nothing();
    let share = 1.0 / (examples.len() * count).max(1) as f64;
    slopes.iter().for_each(|slope| mean.add(slope, share));
    mean
}

/// A block, with the widest instructions there are.
struct BlockTask<'a> {
    judged: Judged<'a>,
    chooser: &'a Chooser,
    sum: &'a mut Slope,
}

impl pulp::NullaryFnOnce for BlockTask<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        slope_of_block(&self.judged, self.chooser, self.sum);
    }
}

/// A network that says next to nothing yet; means and deviations of its inputs are those of the `examples`.
fn start(examples: &[Example], seed: u64) -> Chooser {
    let values = |of: &dyn Fn(&Block, usize) -> (f64, usize)| -> [f64; INPUTS] {
        std::array::from_fn(|input| {
            let blocks = examples.iter().flat_map(|example| &example.blocks).map(|block| of(block, input));
            let (sum, count) = blocks.fold((0.0, 0), |(sum, count), (more, number)| (sum + more, count + number));
            sum / count.max(1) as f64
        })
    };
    let means = values(&|block, input| sum_over(block, input, |v| v));
    let variances = values(&|block, input| sum_over(block, input, |v| (v - means[input]).powi(2)));
    let mut numbers = Numbers::new(seed);
    // Uniform in ±√(3/n), of variance 1/n as is usual.
    let scale = (3.0 / INPUTS as f64).sqrt();
    let mut parameters = Vec::with_capacity(PARAMETERS);
    for _ in 0..HIDDEN {
        parameters.extend([0.0; CANDIDATES]);
        parameters.extend((CANDIDATES..NODE).map(|_| (scale * numbers.symmetric()) as f32));
    }
    parameters.extend((0..HIDDEN).map(|_| (0.02 * numbers.symmetric()) as f32));
    // An input that never varied says nothing; when it does later, it should not shout.
    let deviations = variances.map(|variance| if variance > 1e-6 { variance.sqrt() as f32 } else { 1.0 });
    Chooser { means: means.map(|mean| mean as f32), deviations, parameters }
}

/// Sum of `value` of an input over a block, and of how many numbers.
fn sum_over(block: &Block, input: usize, value: impl Fn(f64) -> f64) -> (f64, usize) {
    let sum = |lanes: &[f32]| lanes.iter().map(|v| value(f64::from(*v))).sum::<f64>();
    match input.checked_sub(OWN) {
        Some(shared) => (sum(&block.shared[shared]), block.shared[shared].len()),
        None => (block.own.iter().map(|own| sum(&own[input])).sum(), CANDIDATES * block.own[0][input].len()),
    }
}

#[cfg(test)]
mod tests;
