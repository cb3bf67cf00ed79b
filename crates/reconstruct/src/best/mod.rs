//! The project's own method: light split into a low layer and events, rebuilt in two passes of collaborative
//! regression, each pixel by the candidates that predict the other half best.
//!
//! Steps, one file each: what exceeds its surroundings goes to a sparse layer (`split`); features are freed of noise
//! (`features`); a first regression guided by the other half (`first_pass`); the sparse layer is spread over pixels
//! that resemble its own (`spread`); what the residual still holds is added (`cascade`), which makes a pilot picture; a
//! second regression is guided by the pilot (`second_pass`); and the candidates are mixed by their error and a small
//! network (`choice`).

pub(crate) mod alone;
mod cascade;
mod choice;
mod colour_guide;
mod error;
mod features;
mod first_pass;
mod given;
pub(crate) mod guided_kernel;
pub(crate) mod halves;
mod restore;
mod second_pass;
mod settings;
pub(crate) mod split;
pub(crate) mod spread;
#[cfg(test)]
pub(crate) mod test_scene;

use std::borrow::Cow;

use stack::{Component, FeatureStack, Image, Monitor, Noise, SampleCounts};

use self::alone::split_alone;
use self::cascade::{Parts, add_significant_residual};
use self::choice::Contest;
use self::colour_guide::with_colour;
use self::given::Given;
use self::guided_kernel::GuidedKernel;
use self::halves::{luminance, mean_of, sum_of};
use self::restore::restore_energy;
use self::split::Layers;
use crate::box_filter::box_mean;
use crate::reconstruction::{ReconstructError, Reconstruction};
use crate::recorruption::evenly_recorrupted_halves;

pub use choice::{Chooser, trained, training};
pub use error::share_unseen;
pub use features::{GuideFeatures, guide_features};
pub use settings::{BestSettings, FitSettings};
use settings::{ChoiceSettings, RestoreSettings};

/// Groups that buckets are put together in for the cascade: fewer are less work and say less about the variance.
const CASCADE_GROUPS: usize = 4;

/// Rebuilds the scattered light `component` of `stack`; the `chooser` helps to mix its candidates. A component that
/// it owns is freed as soon as nothing needs it.
///
/// # Errors
/// When its noise does not come in buckets, or `monitor` cancels.
pub fn rebuild(
    stack: &FeatureStack,
    component: Cow<'_, Component>,
    features: &GuideFeatures,
    settings: &BestSettings,
    chooser: Option<&Chooser>,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let prepared = Prepared::new(stack, component, features, settings, monitor)?;
    monitor.begin("choice", 1);
    let kernel = prepared.kernel(&settings.choice);
    let halves = match prepared.candidates.as_slice() {
        [only] => only.clone(),
        _ => choice::choose(&prepared.contest(&kernel), &settings.choice, chooser),
    };
    let mut picture = mean_of(&halves);
    if settings.restore.levels > 0 {
        let RestoreSettings { feature_scale, brightness, .. } = settings.restore;
        let kernel = GuidedKernel::surfaces_and_brightness(&prepared.features, &picture, feature_scale, brightness);
        restore_energy(&mut picture, &mean_of(&prepared.layers.halves), &kernel, &settings.restore);
    }
    picture.add(&prepared.spread);
    picture.channels_mut().iter_mut().flatten().for_each(|v| *v = v.max(0.0));
    let events = &prepared.layers.events;
    Ok(Reconstruction {
        mse: error::estimated_error(&halves, &prepared.event_variance, &picture, &kernel, &settings.error),
        spikes: Some(sum_of(&events.light)),
        marked: events.energy.iter().filter(|e| **e > 0.0).count(),
        ..Reconstruction::plain(picture)
    })
}

/// Everything up to the choice.
pub(crate) struct Prepared<'a> {
    /// What tells surfaces apart.
    features: Cow<'a, GuideFeatures>,
    layers: Layers,
    /// Spread events.
    spread: Image,
    event_variance: Vec<f32>,
    /// What guided the second pass.
    pilot: Image,
    /// The first pass, then those of the second where there is one.
    candidates: Vec<[Image; 2]>,
}

impl<'a> Prepared<'a> {
    /// All steps up to the choice.
    fn new(
        stack: &FeatureStack,
        component: Cow<'_, Component>,
        features: &'a GuideFeatures,
        settings: &BestSettings,
        monitor: &dyn Monitor,
    ) -> Result<Self, ReconstructError> {
        monitor.begin("spikes", 1);
        let layers = layers_of(&component, stack, settings)?;
        let parts = parts_of(&component, &stack.samples);
        drop(component);
        let noise = relative_noise(&layers);
        let samples = share_of_samples(&stack.samples.total, &settings.regression);
        let given = Given { layers: &layers, noise: &noise, samples: samples.as_deref(), features };
        let first = first_pass::first_pass(&given, &settings.regression, monitor)?;
        monitor.begin("spread", 1);
        let mut pilot = mean_of(&first);
        let surfaces = with_colour(features, stack, &pilot, settings.colour.guide);
        let events = spread::spread(&layers.events, &pilot, &surfaces, &settings.spread);
        let spread = spread::steadied(events.halves, &pilot, &surfaces, &settings.spread, monitor)?;
        pilot.add(&spread);
        if let Some(parts) = parts {
            let kernel = GuidedKernel::surfaces(&surfaces, settings.cascade.feature_scale);
            let brightness = pilot.clone();
            add_significant_residual(&mut pilot, parts, &brightness, &kernel, &settings.cascade, monitor)?;
        }
        let mut candidates = Vec::new();
        if settings.regression.passes > 1 {
            candidates = second_pass::second_pass(&given, &pilot, &first, &settings.regression, monitor)?;
        }
        candidates.insert(0, first);
        Ok(Self { features: surfaces, layers, spread, event_variance: events.variance, pilot, candidates })
    }

    /// What smooths the evidence for a choice.
    fn kernel(&self, settings: &ChoiceSettings) -> GuidedKernel {
        let ChoiceSettings { feature_scale, brightness, .. } = *settings;
        GuidedKernel::surfaces_and_brightness(&self.features, &self.pilot, feature_scale, brightness)
    }

    fn contest<'b>(&'b self, kernel: &'b GuidedKernel) -> Contest<'b> {
        let Self { features, layers, pilot, candidates, .. } = self;
        Contest { candidates, layers, kernel, pilot, features }
    }
}

/// Both layers: by buckets where there are any, else by what is known of the mean.
pub(crate) fn layers_of(
    component: &Component,
    stack: &FeatureStack,
    settings: &BestSettings,
) -> Result<Layers, ReconstructError> {
    match &component.radiance.noise {
        Noise::VarianceOfMean(variance) => Ok(split_alone(&component.radiance.mean, variance)),
        _ => split::split(component, &stack.samples, &settings.split),
    }
}

/// Independent parts of a component for the cascade.
fn parts_of(component: &Component, samples: &SampleCounts) -> Option<Parts> {
    let radiance = &component.radiance;
    match &radiance.noise {
        Noise::VarianceOfMean(variance) => Some(Parts::halves(evenly_recorrupted_halves(&radiance.mean, variance))),
        _ => radiance.groups(samples, CASCADE_GROUPS).map(|groups| Parts::new(groups, samples)),
    }
}

/// Samples of every pixel over their mean; `None` where they do not count or do not differ.
fn share_of_samples(counts: &[u32], settings: &FitSettings) -> Option<Vec<f32>> {
    let differ = counts.windows(2).any(|pair| pair[0] != pair[1]);
    let mean = counts.iter().map(|n| f64::from(*n)).sum::<f64>() / counts.len() as f64;
    let share = |n: &u32| (f64::from((*n).max(1)) / mean) as f32;
    (settings.weigh_samples && differ).then(|| counts.iter().map(share).collect())
}

/// ν = variance of a half relative to the squared luminance L² + 0.001 around it, both over 5×5 pixels.
fn relative_noise(layers: &Layers) -> Vec<f32> {
    let size = layers.variance.size();
    let luminance = box_mean(&luminance(&mean_of(&layers.halves)), size, 2);
    let relative = |(i, l): (usize, &f32)| layers.variance.mean_at(i) / (l * l + 1e-3);
    box_mean(&luminance.iter().enumerate().map(relative).collect::<Vec<f32>>(), size, 2)
}

#[cfg(test)]
mod tests;
