//! Candidates mixed by how well each predicts the half it was not made from, and by a small network that has learned what
//! such errors are worth.
//!
//! Errors between halves (`evidence`) are unbiased and noisy: a rule that follows the least of them follows noise. What
//! else is known about a pixel (`inputs`, `detail`) tells how much to trust them; the network (`chooser`) adds that to the
//! rule's score. Its weights are trained (`training`) on renders whose references are known, and come along (`weights`).
//! Last, a first pass that stands alone is held back (`runaway`).

mod chooser;
mod detail;
mod evidence;
mod inputs;
mod runaway;
pub mod training;
mod weights;

use rayon::prelude::*;
use stack::Image;

use super::edge_avoiding::EdgeAvoidingKernel;
use super::features::CleanFeatures;
use super::settings::ChoiceSettings;
use super::split::LowLayer;
use crate::bands::{bands, image_rows};
use crate::box_filter::box_mean;
use crate::network::lanes_of;
pub use chooser::Chooser;
use chooser::softmax;
use evidence::{CANDIDATES, Evidence, FEW, Scales};
use inputs::{Inputs, LANES, Lanes, rule_scores};
use runaway::hold_back;
pub use weights::chooser_of;
#[cfg(test)]
pub use weights::trained;

/// Radius of the box that smooths weights, in pixels.
const WEIGHT_RADIUS: usize = 2;

/// Rows of a mixture that are made at once: what is known about all candidates takes more memory than anything else, and
/// what the rule alone asks for less than half of it.
const ROWS: usize = 192;
const ROWS_OF_RULE: usize = 256;

/// Pixels of a mixture that one task makes.
const CHUNK: usize = 4096;

/// How far from a pixel a choice looks, in pixels.
pub const REACH: usize = evidence::REACH + WEIGHT_RADIUS;

/// The same for the rule alone.
const REACH_OF_RULE: usize = evidence::REACH_OF_RULE + WEIGHT_RADIUS;

/// What there is to choose from, and what it is judged by.
#[derive(Clone, Copy)]
pub struct Contest<'a> {
    /// Both halves of every candidate, in the order the network was trained with.
    pub candidates: &'a [[Image; 2]],
    /// The noisy halves and their variance.
    pub low: &'a LowLayer,
    /// The picture that guided the candidates.
    pub pilot: &'a Image,
    /// Features.
    pub features: &'a CleanFeatures,
}

impl Contest<'_> {
    /// What smooths errors.
    fn kernel(&self, settings: &ChoiceSettings) -> EdgeAvoidingKernel<'_> {
        let ChoiceSettings { feature_scale, brightness, .. } = *settings;
        EdgeAvoidingKernel::on_surfaces_of_like_brightness(self.features, self.pilot, feature_scale, brightness)
    }
}

/// What each candidate weighs, a channel for each, by the rule or, where there is one, by the rule and the `chooser`.
///
/// # Panics
/// When there are neither all candidates nor, for the rule alone, the few: that is a mistake in the calling code.
pub fn weights(contest: &Contest, settings: &ChoiceSettings, chooser: Option<&Chooser>) -> Image {
    let count = contest.candidates.len();
    assert!(count == CANDIDATES || (count == FEW && chooser.is_none()), "the network knows {CANDIDATES} candidates");
    let size = contest.pilot.size();
    let mut weights = Image::zeros(size, count);
    let (rows, reach) = match chooser {
        Some(_) => (ROWS, REACH),
        None => (ROWS_OF_RULE, REACH_OF_RULE),
    };
    for band in bands(size.height, rows, reach) {
        let rows = |image: &Image| image_rows(image, &band.around);
        let candidates: Vec<_> = contest.candidates.par_iter().map(|halves| halves.each_ref().map(rows)).collect();
        let (low, features) = (contest.low.rows(&band.around), contest.features.rows(&band.around));
        let pilot = rows(contest.pilot);
        let part = Contest { candidates: &candidates, low: &low, pilot: &pilot, features: &features };
        band.put(&weights_at_once(&part, settings, chooser), &mut weights);
    }
    weights
}

fn weights_at_once(contest: &Contest, settings: &ChoiceSettings, chooser: Option<&Chooser>) -> Image {
    let evidence = || Evidence::new(contest, settings, Scales::OfTheRule);
    let weights = match chooser {
        Some(chooser) => weigh(contest, &Learned { inputs: &Inputs::new(contest, settings), chooser }),
        None if contest.candidates.len() == FEW => weigh::<FEW>(contest, &Rule { evidence: &evidence(), settings }),
        None => weigh::<CANDIDATES>(contest, &Rule { evidence: &evidence(), settings }),
    };
    let size = contest.pilot.size();
    let mut weights: Vec<Vec<f32>> = weights.par_iter().map(|plane| box_mean(plane, size, WEIGHT_RADIUS)).collect();
    hold_back(&mut weights, contest.candidates);
    Image::from_channels(size, weights)
}

/// What gives `N` candidates their weights.
trait Judge<const N: usize>: Sync {
    /// What each candidate weighs at these pixels; together 1.
    fn weights(&self, pixels: &[usize; LANES]) -> [Lanes; N];
}

/// Errors alone.
struct Rule<'a> {
    evidence: &'a Evidence,
    settings: &'a ChoiceSettings,
}

impl<const N: usize> Judge<N> for Rule<'_> {
    #[inline(always)]
    fn weights(&self, pixels: &[usize; LANES]) -> [Lanes; N] {
        softmax(rule_scores(self.evidence.level_of_rule(), pixels, self.settings))
    }
}

/// Errors and the network.
struct Learned<'a> {
    inputs: &'a Inputs<'a>,
    chooser: &'a Chooser,
}

impl Judge<CANDIDATES> for Learned<'_> {
    #[inline(always)]
    fn weights(&self, pixels: &[usize; LANES]) -> [Lanes; CANDIDATES] {
        self.chooser.weights(&self.inputs.block(pixels))
    }
}

/// A plane of weights for every candidate.
fn weigh<const N: usize>(contest: &Contest, judge: &impl Judge<N>) -> Vec<Vec<f32>> {
    let pixels = contest.pilot.pixels();
    let weighed = |pixels| pulp::Arch::new().dispatch(BlockTask::<_, N> { pixels, judge });
    let blocks: Vec<[Lanes; N]> = lanes_of(pixels).map(weighed).collect();
    let plane = |k: usize| blocks.iter().flat_map(|block| block[k]).take(pixels).collect();
    (0..N).into_par_iter().map(plane).collect()
}

/// Some pixels, weighed with the widest instructions there are.
struct BlockTask<'a, J, const N: usize> {
    pixels: [usize; LANES],
    judge: &'a J,
}

impl<const N: usize, J: Judge<N>> pulp::NullaryFnOnce for BlockTask<'_, J, N> {
    type Output = [Lanes; N];

    #[inline(always)]
    fn call(self) -> Self::Output {
        self.judge.weights(&self.pixels)
    }
}

/// Both halves of all `candidates`, added up with their `weights`.
pub fn mixtures(candidates: &[[Image; 2]], weights: &[Vec<f32>]) -> [Image; 2] {
    [0, 1].map(|half: usize| {
        let mut mixed = Image::zeros(candidates[0][half].size(), 3);
        for (c, plane) in mixed.channels_mut().iter_mut().enumerate() {
            plane.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, sums)| {
                let pixels = chunk * CHUNK..chunk * CHUNK + sums.len();
                for (candidate, weights) in candidates.iter().zip(weights) {
                    let (values, weights) = (&candidate[half].channels()[c][pixels.clone()], &weights[pixels.clone()]);
                    sums.iter_mut().zip(values).zip(weights).for_each(|((sum, value), weight)| *sum += weight * value);
                }
            });
        }
        mixed
    })
}

#[cfg(test)]
mod tests;
