//! The project's own method: light split into a low layer and events, rebuilt in two passes of collaborative
//! regression, each pixel by the candidate that predicts the other half best.
//!
//! Steps, one file each: what exceeds its surroundings goes to a sparse layer (`split`); features are freed of noise
//! (`features`); a first regression guided by the other half (`first_pass`); the sparse layer is spread over pixels
//! that resemble its own (`spread`); what the residual still holds is added (`cascade`), which makes a pilot picture; a
//! second regression is guided by the pilot (`second_pass`); and the candidates are mixed by their error (`choice`).

mod cascade;
mod choice;
mod error;
mod features;
mod first_pass;
mod given;
mod guided_kernel;
mod halves;
mod restore;
mod second_pass;
mod settings;
mod split;
mod spread;
#[cfg(test)]
mod test_scene;

use std::borrow::Cow;

use stack::{Component, FeatureStack, Monitor};

use self::cascade::{Parts, add_significant_residual};
use self::given::Given;
use self::guided_kernel::GuidedKernel;
use self::halves::{luminance, mean_of, sum_of};
use self::restore::restore_energy;
use crate::box_filter::box_mean;
use crate::reconstruction::{ReconstructError, Reconstruction};

pub use error::share_unseen;
pub use features::{GuideFeatures, guide_features};
pub use settings::{BestSettings, FitSettings};
use settings::{ChoiceSettings, RestoreSettings};

/// Groups that buckets are put together in for the cascade: fewer are less work and say less about the variance.
const CASCADE_GROUPS: usize = 4;

/// Rebuilds the scattered light `component` of `stack`. One that it owns is freed as soon as nothing needs it.
///
/// # Errors
/// When its noise does not come in buckets, or `monitor` cancels.
pub fn rebuild(
    stack: &FeatureStack,
    component: Cow<'_, Component>,
    features: &GuideFeatures,
    settings: &BestSettings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    monitor.begin("spikes", 1);
    let layers = split::split(&component, &stack.samples, &settings.split)?;
    let groups = component.radiance.groups(&stack.samples, CASCADE_GROUPS);
    drop(component);
    let noise = relative_noise(&layers);
    let samples = share_of_samples(&stack.samples.total, &settings.regression);
    let given = Given { layers: &layers, noise: &noise, samples: samples.as_deref(), features };
    let first = first_pass::first_pass(&given, &settings.regression, monitor)?;
    monitor.begin("spread", 1);
    let mut pilot = mean_of(&first);
    let events = spread::spread(&layers.events, &pilot, features, &settings.spread);
    let spread = spread::steadied(events.halves, &pilot, features, &settings.spread, monitor)?;
    pilot.add(&spread);
    if let Some(groups) = groups {
        let parts = Parts::new(groups, &stack.samples);
        let kernel = GuidedKernel::surfaces(features, settings.cascade.feature_scale);
        let brightness = pilot.clone();
        add_significant_residual(&mut pilot, parts, &brightness, &kernel, &settings.cascade, monitor)?;
    }
    let mut candidates = Vec::new();
    if settings.regression.passes > 1 {
        candidates = second_pass::second_pass(&given, &pilot, &first, &settings.regression, monitor)?;
    }
    candidates.insert(0, first);
    let ChoiceSettings { feature_scale, brightness, .. } = settings.choice;
    let kernel = GuidedKernel::surfaces_and_brightness(features, &pilot, feature_scale, brightness);
    drop(pilot);
    monitor.begin("choice", 1);
    let halves = match <[_; 1]>::try_from(candidates) {
        Ok([only]) => only,
        Err(candidates) => choice::choose(&candidates, &layers, &kernel, &settings.choice),
    };
    let mut picture = mean_of(&halves);
    if settings.restore.levels > 0 {
        let RestoreSettings { feature_scale, brightness, .. } = settings.restore;
        let kernel = GuidedKernel::surfaces_and_brightness(features, &picture, feature_scale, brightness);
        restore_energy(&mut picture, &mean_of(&layers.halves), &kernel, &settings.restore);
    }
    picture.add(&spread);
    picture.channels_mut().iter_mut().flatten().for_each(|v| *v = v.max(0.0));
    Ok(Reconstruction {
        mse: error::estimated_error(&halves, &events.variance, &picture, &kernel, &settings.error),
        spikes: Some(sum_of(&layers.events.light)),
        marked: layers.events.energy.iter().filter(|e| **e > 0.0).count(),
        ..Reconstruction::plain(picture)
    })
}

/// Samples of every pixel over their mean; `None` where they do not count or do not differ.
fn share_of_samples(counts: &[u32], settings: &FitSettings) -> Option<Vec<f32>> {
    let differ = counts.windows(2).any(|pair| pair[0] != pair[1]);
    let mean = counts.iter().map(|n| f64::from(*n)).sum::<f64>() / counts.len() as f64;
    let share = |n: &u32| (f64::from((*n).max(1)) / mean) as f32;
    (settings.weigh_samples && differ).then(|| counts.iter().map(share).collect())
}

/// ν = variance of a half relative to the squared luminance L² + 0.001 around it, both over 5×5 pixels.
fn relative_noise(layers: &split::Layers) -> Vec<f32> {
    let size = layers.variance.size();
    let luminance = box_mean(&luminance(&mean_of(&layers.halves)), size, 2);
    let relative = |(i, l): (usize, &f32)| layers.variance.mean_at(i) / (l * l + 1e-3);
    box_mean(&luminance.iter().enumerate().map(relative).collect::<Vec<f32>>(), size, 2)
}

#[cfg(test)]
mod tests;
