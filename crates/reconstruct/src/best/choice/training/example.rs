//! A noisy picture's candidates and what the picture should have been.

use std::borrow::Cow;

use stack::{ComponentRole, FeatureStack, Image, Monitor};

use super::answer::{Answer, Judged};
use super::lights::{Light, Parts, parts_of, whole_light};
use super::slope::{errors_of_rule, norm_of};
use crate::best::choice::inputs::{Block, Inputs, LANES};
use crate::best::features::{CleanFeatures, clean_features};
use crate::best::light_features::with_direct_light;
use crate::best::piloted::Piloted;
use crate::best::rebuild::rebuild;
use crate::best::recipe::{Extras, Recipe};
use crate::best::settings::BestSettings;
use crate::exposure::{Exposed, exposure};
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
    /// them; the references are independent of each other. Direct light, though the network may not be asked about it, is
    /// much like stacks with little noise. Pixels that see a lamp are left out; which of the others are kept, `seed` says.
    ///
    /// # Errors
    /// When the stack has no scattered light or cannot be rebuilt, when only a few candidates are made, and when `monitor`
    /// cancels.
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
        settings.check_candidates()?;
        let exposure = exposure(&stack.components, settings.light.usual_brightness());
        let stack = &stack.clone().exposed(exposure);
        let references = &references.clone().map(|reference| reference.exposed(exposure));
        let features = clean_features(stack, settings, monitor)?;
        let whole = whole_light(stack, references)?;
        let parts = parts_of(&whole, stack, references, settings.light.gathered);
        let pixels = sampled(&unlit(stack), seed);
        let picture = Picture { stack, settings, whole: &whole.references.clone(), pixels };
        let mut examples = vec![picture.example(whole, &features, None, monitor)?];
        if let Some(Parts { direct, indirect, share }) = parts {
            let of_direct = settings.for_direct_light(share);
            let features = &features;
            let recipe = Recipe { settings: &of_direct, ..picture.recipe(features, None) };
            let rebuilt = rebuild(&recipe, Cow::Borrowed(&direct.component), monitor)?.picture;
            let extended = with_direct_light(features, &rebuilt, settings.light.direct_guide);
            examples.push(picture.example(direct, features, None, monitor)?);
            examples.push(picture.example(indirect, extended.as_ref().unwrap_or(features), Some(&rebuilt), monitor)?);
        }
        Ok(examples)
    }

    /// One of its blocks, counted round and round.
    pub(super) fn judged(&self, number: usize) -> Judged<'_> {
        let number = number % self.blocks.len();
        Judged { block: &self.blocks[number], answer: &self.answers[number], norm: self.norm }
    }
}

impl<'a> Picture<'a> {
    fn recipe(&self, features: &'a CleanFeatures, beside: Option<&'a Image>) -> Recipe<'a> {
        let Self { stack, settings, .. } = *self;
        Recipe { counts: &stack.samples, features, beside, settings, chooser: None, extras: Extras::default() }
    }

    fn example(
        &self,
        light: Light,
        features: &CleanFeatures,
        beside: Option<&Image>,
        monitor: &dyn Monitor,
    ) -> Result<Example, ReconstructError> {
        let Self { settings, whole, pixels, .. } = self;
        let (piloted, events) = Piloted::new(&self.recipe(features, beside), light.component, monitor)?;
        let Piloted { given, first, .. } = &piloted;
        let candidates = piloted.candidates(&given.low.halves, first, &settings.regression, monitor)?;
        let contest = piloted.contest(&candidates);
        let inputs = Inputs::new(&contest, &settings.choice);
        let blocks: Vec<Block> = pixels.iter().map(|pixels| inputs.block(pixels)).collect();
        let answer = |pixels| Answer::new(&contest, &events.light, [&light.references, whole], pixels);
        let answers: Vec<Answer> = pixels.iter().map(answer).collect();
        let norm = norm_of(errors_of_rule(&blocks, &answers));
        Ok(Example { blocks, answers, norm })
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
