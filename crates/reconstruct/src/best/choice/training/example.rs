//! A noisy picture's candidates and what the picture should have been.

use std::borrow::Cow;

use stack::{Component, ComponentRole, FeatureStack, Image, Monitor};

use super::slope::{errors_of_rule, norm_of};
use crate::best::choice::Contest;
use crate::best::choice::evidence::CANDIDATES;
use crate::best::choice::inputs::{Block, Inputs, LANES, Lanes};
use crate::best::piloted::Piloted;
use crate::best::settings::BestSettings;
use crate::best::{Extras, GuideFeatures, Workshop, guide_features, with_direct_light};
use crate::components::is_lit;
use crate::indirect::{is_part_of, take_off, without};
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
    /// What a squared error is divided by: mean² + 0.001, the mean that of the references' scattered light.
    pub scale: [Lanes; 3],
}

/// A block with its answer.
pub(super) struct Judged<'a> {
    pub block: &'a Block,
    pub answer: &'a Answer,
    /// What errors of this picture are relative to, so that no picture drowns the others.
    pub norm: f32,
}

/// Light that is rebuilt by itself.
struct Light<'a> {
    component: Cow<'a, Component>,
    /// The same light in both references.
    references: [Image; 2],
}

/// What examples of a picture have in common.
struct Picture<'a> {
    stack: &'a FeatureStack,
    settings: &'a BestSettings,
    /// All scattered light in both references.
    whole: &'a [Image; 2],
    /// Pixels that are kept.
    pixels: Vec<[usize; LANES]>,
}

impl Example {
    /// The scattered light of `stack`, and, where it and both references keep direct and indirect light apart, either of
    /// them; the references are independent of each other. Pixels that see a lamp are left out; which of the others are
    /// kept, `seed` says.
    ///
    /// # Errors
    /// When the stack has no scattered light or cannot be rebuilt, and when `monitor` cancels.
    ///
    /// # Panics
    /// When a reference has another size or no scattered light: that is a mistake in the calling code.
    pub fn all_of(
        stack: &FeatureStack,
        references: &[FeatureStack; 2],
        settings: &BestSettings,
        seed: u64,
        monitor: &dyn Monitor,
    ) -> Result<Vec<Self>, ReconstructError> {
        let features = guide_features(stack, &settings.features, monitor)?;
        let whole = whole_light(stack, references)?;
        let parts = parts_of(&whole, stack, references);
        let pixels = sampled(&unlit(stack), seed);
        let picture = Picture { stack, settings, whole: &whole.references.clone(), pixels };
        let mut examples = vec![picture.example(whole, &features, monitor)?];
        if let Some([direct, indirect]) = parts {
            let workshop = Workshop { stack, features: &features, settings, chooser: None, extras: Extras::default() };
            let rebuilt = workshop.rebuild(Cow::Borrowed(&direct.component), monitor)?.picture;
            let guided = with_direct_light(&features, &rebuilt, settings.light.direct_guide);
            examples.push(picture.example(direct, &features, monitor)?);
            examples.push(picture.example(indirect, &guided, monitor)?);
        }
        Ok(examples)
    }

    /// One of its blocks, counted round and round.
    pub(super) fn judged(&self, number: usize) -> Judged<'_> {
        let number = number % self.blocks.len();
        Judged { block: &self.blocks[number], answer: &self.answers[number], norm: self.norm }
    }
}

impl Picture<'_> {
    fn example(
        &self,
        light: Light,
        features: &GuideFeatures,
        monitor: &dyn Monitor,
    ) -> Result<Example, ReconstructError> {
        let Self { stack, settings, whole, pixels } = self;
        let piloted = Piloted::new(stack, light.component, features, settings, &[], monitor)?;
        let Piloted { layers, first, .. } = &piloted;
        let candidates = piloted.candidates(&layers.halves, first, &settings.regression, monitor)?;
        let contest = piloted.contest(&candidates);
        let inputs = Inputs::new(&contest, &settings.choice);
        let blocks: Vec<Block> = pixels.iter().map(|pixels| inputs.block(pixels)).collect();
        let answer = |pixels| Answer::new(&contest, &piloted.spread, [&light.references, whole], pixels);
        let answers: Vec<Answer> = pixels.iter().map(answer).collect();
        let norm = norm_of(errors_of_rule(&blocks, &answers));
        Ok(Example { blocks, answers, norm })
    }
}

fn whole_light<'a>(stack: &'a FeatureStack, references: &[FeatureStack; 2]) -> Result<Light<'a>, ReconstructError> {
    let layer = ComponentRole::Scattered.layer();
    let component = stack.component(ComponentRole::Scattered).ok_or(ReconstructError::NoiseUnknown { layer })?;
    let scattered = |reference: &FeatureStack| {
        assert_eq!(reference.size(), stack.size());
        reference.component(ComponentRole::Scattered).expect("a reference with scattered light").radiance.mean.clone()
    };
    Ok(Light { component: Cow::Borrowed(component), references: references.each_ref().map(scattered) })
}

/// Direct and indirect light, where they are known apart and there is some of both.
fn parts_of(whole: &Light, stack: &FeatureStack, references: &[FeatureStack; 2]) -> Option<[Light<'static>; 2]> {
    let radiance = stack.indirect.as_ref().filter(|indirect| is_part_of(indirect, &whole.component.radiance))?;
    let [Some(first), Some(second)] = references.each_ref().map(|reference| reference.indirect.as_ref()) else {
        return None;
    };
    let of_indirect = [first, second].map(|estimate| estimate.mean.clone());
    let mut of_direct = whole.references.clone();
    of_direct.iter_mut().zip(&of_indirect).for_each(|(whole, part)| take_off(whole, part));
    let direct = without(whole.component.clone().into_owned(), radiance);
    let indirect = Component { role: ComponentRole::Scattered, radiance: radiance.clone() };
    let parts = [(direct, of_direct), (indirect, of_indirect)];
    let both_lit = parts.iter().all(|(component, _)| is_lit(component));
    both_lit.then(|| parts.map(|(component, references)| Light { component: Cow::Owned(component), references }))
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
    fn new(contest: &Contest, spread: &Image, [references, whole]: [&[Image; 2]; 2], pixels: &[usize; LANES]) -> Self {
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
