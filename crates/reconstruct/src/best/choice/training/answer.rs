//! What the mixture of a block should be.

use stack::Image;

use crate::best::choice::Contest;
use crate::best::choice::evidence::CANDIDATES;
use crate::best::choice::inputs::{Block, LANES, Lanes};

/// What becomes of the pixels of a block.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The candidates' RGB, mean of halves.
    pub candidates: [[Lanes; 3]; CANDIDATES],
    /// What the mixture should be, by either reference: the reference without spread events.
    pub truth: [[Lanes; 3]; 2],
    /// What a squared error is divided by: mean² + 0.001, the mean that of the references' scattered light.
    pub scale: [Lanes; 3],
}

/// A block with its answer.
pub struct Judged<'a> {
    pub block: &'a Block,
    pub answer: &'a Answer,
    /// What errors of this picture are relative to, so that no picture drowns the others.
    pub norm: f32,
}

impl Answer {
    /// What becomes of `pixels`: `references` are those of the light that is rebuilt, `whole` those of all light.
    pub fn new(
        contest: &Contest,
        spread: &Image,
        [references, whole]: [&[Image; 2]; 2],
        pixels: &[usize; LANES],
    ) -> Self {
        let lanes = |value: &dyn Fn(usize, usize) -> f32| -> [Lanes; 3] {
            std::array::from_fn(|c| pixels.map(|pixel| value(c, pixel)))
        };
        let candidate = |k: usize| {
            let [a, b] = &contest.candidates[k];
            lanes(&|c, pixel| 0.5 * (a.channels()[c][pixel] + b.channels()[c][pixel]))
        };
        let at = |image: &Image, c: usize, pixel: usize| image.channels()[c][pixel];
        Self {
            candidates: std::array::from_fn(candidate),
            truth: references.each_ref().map(|reference| lanes(&|c, p| at(reference, c, p) - at(spread, c, p))),
            scale: lanes(&|c, p| (0.5 * (at(&whole[0], c, p) + at(&whole[1], c, p))).powi(2) + 1e-3),
        }
    }
}
