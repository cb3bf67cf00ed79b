//! Everything up to the second pass: first pass, spread events, and the pilot picture that is made of them.

use std::borrow::Cow;
use std::ops::Range;

use stack::{Cancelled, Component, Image, Monitor, Noise, SampleCounts};

use super::cascade::{Parts, add_significant_residual, relative_to};
use super::choice::Contest;
use super::edge_avoiding::EdgeAvoidingKernel;
use super::features::CleanFeatures;
use super::first_pass::first_pass;
use super::given::Given;
use super::halves::mean_of;
use super::light_features::with_colour;
use super::passes::{Pass, low_layers, through_first_pass};
use super::recipe::Recipe;
use super::second_pass::second_pass;
use super::settings::FitSettings;
use super::split::{Events, Layers, split};
use super::spread::lines::{brightness_of_lines, with_lines};
use super::spread::{spread, steadied};
use crate::bands::image_rows;
use crate::reconstruction::ReconstructError;
use crate::recorruption::evenly_recorrupted_halves;
use crate::variance::known_everywhere;

/// What the second pass and the choice work on.
#[derive(Clone)]
pub struct Piloted<'a> {
    pub given: Given<'a>,
    /// The features with colours, where they alone do not tell surfaces apart.
    coloured: Option<CleanFeatures>,
    /// What guides the second pass: first pass, spread events, and what the residual significantly holds.
    pub pilot: Image,
    /// Both halves of the first pass.
    pub first: [Image; 2],
    /// Passes, and last what the light has beside them; nothing when none are asked for.
    pub passes: Vec<Pass>,
}

/// Events after they were spread.
pub struct SpreadEvents {
    /// Their light where it belongs.
    pub light: Image,
    /// Variance of that, mean over RGB.
    pub variance: Vec<f32>,
    /// As they were cut.
    pub cut: Events,
}

impl<'a> Piloted<'a> {
    /// All steps up to the second pass. A `component` that is owned is freed as soon as its layers are made.
    ///
    /// # Errors
    /// When nothing is known about its noise, or `monitor` cancels.
    pub fn new(
        recipe: &Recipe<'a>,
        component: Cow<'_, Component>,
        monitor: &dyn Monitor,
    ) -> Result<(Self, SpreadEvents), ReconstructError> {
        let Recipe { counts, features, beside, settings, extras, .. } = *recipe;
        monitor.begin("spikes", 1);
        let Layers { low, events } = split(&component, counts, &settings.split)?;
        let parts = parts_of(&component, counts, settings.cascade.parts);
        let of_passes = match extras.passes {
            [] => Vec::new(),
            passes => low_layers(passes, &component.radiance.mean, &mean_of(&low.halves)),
        };
        drop(component);
        let given = Given::new(low, counts, features, &settings.regression);
        let first = first_pass(&given.low.halves, &given, &settings.regression, monitor)?;
        let passes = through_first_pass(of_passes, &given, &settings.regression, monitor)?;
        monitor.begin("spread", 1);
        let mut pilot = mean_of(&first);
        let coloured = with_colour(features, &pilot, settings.colour.guide);
        let separating = coloured.as_ref().unwrap_or(features);
        let lit = with_share(&pilot, beside, settings.light.direct_spread);
        let lines = brightness_of_lines(&events, separating, &settings.spread);
        let spread = spread(&events, &with_lines(&lit, &lines), separating, &settings.spread);
        drop(lit);
        let light = steadied(spread.halves, &with_lines(&pilot, &lines), separating, &settings.spread, monitor)?;
        pilot.add(&light);
        if let Some(parts) = parts {
            let kernel = EdgeAvoidingKernel::on_surfaces(separating, settings.cascade.feature_scale);
            let relative = relative_to(&pilot);
            let scrutiny = settings.cascade.scrutiny(parts.count());
            add_significant_residual(&mut pilot, parts, relative, |step| kernel.taps(step), scrutiny, monitor)?;
        }
        let events = SpreadEvents { light, variance: spread.variance, cut: events };
        Ok((Self { given, coloured, pilot, first, passes }, events))
    }

    /// Some rows of all that.
    pub fn rows(&self, rows: &Range<usize>) -> Piloted<'static> {
        Piloted {
            given: self.given.rows(rows),
            coloured: self.coloured.as_ref().map(|features| features.rows(rows)),
            pilot: image_rows(&self.pilot, rows),
            first: self.first.each_ref().map(|half| image_rows(half, rows)),
            passes: self.passes.iter().map(|pass| pass.rows(rows)).collect(),
        }
    }

    /// What both regressions make of two `images`: the `first` of it, and the candidates of the second pass.
    ///
    /// # Errors
    /// When `monitor` cancels.
    pub fn candidates(
        &self,
        images: &[Image; 2],
        first: &[Image; 2],
        settings: &FitSettings,
        monitor: &dyn Monitor,
    ) -> Result<Vec<[Image; 2]>, Cancelled> {
        let mut candidates = second_pass(images, &self.given, &self.pilot, &self.first, settings, monitor)?;
        candidates.insert(0, first.clone());
        Ok(candidates)
    }

    /// Features whose separators do tell surfaces apart.
    pub fn separating_features(&self) -> &CleanFeatures {
        self.coloured.as_ref().unwrap_or(&self.given.features)
    }

    /// What is to be chosen from `candidates`.
    pub fn contest<'b>(&'b self, candidates: &'b [[Image; 2]]) -> Contest<'b> {
        Contest { candidates, low: &self.given.low, pilot: &self.pilot, features: self.separating_features() }
    }
}

/// `picture` and `share` of what is `beside` it.
fn with_share<'a>(picture: &'a Image, beside: Option<&Image>, share: f32) -> Cow<'a, Image> {
    let Some(beside) = beside.filter(|_| share > 0.0) else { return Cow::Borrowed(picture) };
    let mut sum = picture.clone();
    for (sum, plane) in sum.channels_mut().iter_mut().zip(beside.channels()) {
        sum.iter_mut().zip(plane).for_each(|(sum, v)| *sum += share * v);
    }
    Cow::Owned(sum)
}

/// Independent parts of a component for the cascade, at `most` so many where it has buckets.
fn parts_of(component: &Component, counts: &SampleCounts, most: usize) -> Option<Parts> {
    let radiance = &component.radiance;
    match &radiance.noise {
        Noise::VarianceOfMean(variance) => {
            let variance = known_everywhere(variance.clone(), &radiance.mean);
            Some(Parts::halves(&evenly_recorrupted_halves(&radiance.mean, &variance)))
        }
        _ => radiance.groups(counts, most).map(|groups| Parts::new(groups, counts)),
    }
}
