//! A noisy picture's candidates and what the picture should have been.

use std::borrow::Cow;

use stack::{ComponentRole, FeatureStack, Image, Monitor};

use super::slope::{errors_of_rule, norm_of};
use crate::best::choice::Contest;
use crate::best::choice::evidence::CANDIDATES;
use crate::best::choice::inputs::{Block, Inputs, LANES, Lanes};
use crate::best::guide_features;
use crate::best::piloted::Piloted;
use crate::best::settings::BestSettings;
use crate::network::Numbers;
use crate::reconstruction::ReconstructError;

/// Blocks that are kept of a picture.
const BLOCKS: usize = 256;

/// One picture of the training set, of which some pixels are kept.
#[derive(Clone, Debug)]
pub struct Example {
    /// What the network is told.
    pub(super) blocks: Vec<Block>,
    answers: Vec<Answer>,
    /// Mean size of the rule's errors.
    norm: f32,
}

/// What becomes of the pixels of a block.
#[derive(Clone, Debug)]
pub(super) struct Answer {
    /// The candidates' RGB, mean of halves.
    pub candidates: [[Lanes; 3]; CANDIDATES],
    /// What the mixture should be, by either reference: the reference without spread events.
    pub truth: [[Lanes; 3]; 2],
    /// What a squared error is divided by: mean² + 0.001, the mean that of the references.
    pub scale: [Lanes; 3],
}

/// A block with its answer.
pub(super) struct Judged<'a> {
    pub block: &'a Block,
    pub answer: &'a Answer,
    /// What errors of this picture are relative to, so that no picture drowns the others.
    pub norm: f32,
}

impl Example {
    /// The scattered light of `stack`, with two independent references of the same light. Pixels that see a lamp are
    /// left out; which of the others are kept, `seed` says.
    ///
    /// # Errors
    /// When the stack has no scattered light or cannot be rebuilt, and when `monitor` cancels.
    ///
    /// # Panics
    /// When a reference has another size or number of channels: that is a mistake in the calling code.
    pub fn new(
        stack: &FeatureStack,
        references: &[Image; 2],
        settings: &BestSettings,
        seed: u64,
        monitor: &dyn Monitor,
    ) -> Result<Self, ReconstructError> {
        for reference in references {
            assert_eq!((reference.size(), reference.channels().len()), (stack.size(), 3));
        }
        let layer = ComponentRole::Scattered.layer();
        let component = stack.component(ComponentRole::Scattered).ok_or(ReconstructError::NoiseUnknown { layer })?;
        let features = guide_features(stack, &settings.features, monitor)?;
        let piloted = Piloted::new(stack, Cow::Borrowed(component), &features, settings, &[], monitor)?;
        let Piloted { layers, first, .. } = &piloted;
        let candidates = piloted.candidates(&layers.halves, first, &settings.regression, monitor)?;
        let contest = piloted.contest(&candidates);
        let inputs = Inputs::new(&contest, &settings.choice);
        let pixels = sampled(&unlit(stack), seed);
        let blocks: Vec<Block> = pixels.iter().map(|pixels| inputs.block(pixels)).collect();
        let answer = |pixels: &[usize; LANES]| Answer::new(&contest, &piloted.spread, references, pixels);
        let answers: Vec<Answer> = pixels.iter().map(answer).collect();
        let norm = norm_of(errors_of_rule(&blocks, &answers));
        Ok(Self { blocks, answers, norm })
    }

    /// One of its blocks, counted round and round.
    pub(super) fn judged(&self, number: usize) -> Judged<'_> {
        let number = number % self.blocks.len();
        Judged { block: &self.blocks[number], answer: &self.answers[number], norm: self.norm }
    }
}

/// Pixels that see no lamp.
fn unlit(stack: &FeatureStack) -> Vec<usize> {
    let emission = stack.component(ComponentRole::Emission).map(|component| &component.radiance.mean);
    let is_lit = |pixel: usize| emission.is_some_and(|image| image.rgb(pixel).iter().any(|v| *v != 0.0));
    (0..stack.size().pixels()).filter(|pixel| !is_lit(*pixel)).collect()
}

/// Blocks of these pixels in random order, no more than [`BLOCKS`]. Every pixel where there are none: a picture of lamps
/// teaches nothing, and no pixel of it is off.
fn sampled(pixels: &[usize], seed: u64) -> Vec<[usize; LANES]> {
    let mut pixels = if pixels.is_empty() { vec![0] } else { pixels.to_vec() };
    Numbers::new(seed).shuffle(&mut pixels);
    let blocks = (pixels.len() / LANES).clamp(1, BLOCKS);
    (0..blocks).map(|block| std::array::from_fn(|lane| pixels[(block * LANES + lane) % pixels.len()])).collect()
}

impl Answer {
    fn new(contest: &Contest, spread: &Image, references: &[Image; 2], pixels: &[usize; LANES]) -> Self {
        let lanes = |value: &dyn Fn(usize, usize) -> f32| -> [Lanes; 3] {
            std::array::from_fn(|c| pixels.map(|pixel| value(c, pixel)))
        };
        let candidate = |k: usize| {
            let [a, b] = &contest.candidates[k];
            lanes(&|c, pixel| 0.5 * (a.channels()[c][pixel] + b.channels()[c][pixel]))
        };
        let reference = |which: usize, c: usize, pixel: usize| references[which].channels()[c][pixel];
        Self {
            candidates: std::array::from_fn(candidate),
            truth: [0, 1].map(|which| lanes(&|c, p| reference(which, c, p) - spread.channels()[c][p])),
            scale: lanes(&|c, p| (0.5 * (reference(0, c, p) + reference(1, c, p))).powi(2) + 1e-3),
        }
    }
}
