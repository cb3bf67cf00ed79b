//! A picture rebuilt from its stack: every component by the method that was asked for, then their sum.

use std::borrow::Cow;

use stack::{Component, ComponentRole, Estimate, FeatureStack, Image, Monitor, Noise};

use crate::best::{Chooser, GuideFeatures};
use crate::completion::{Completed, complete};
use crate::components::{is_lit, sum_of_components, variance_of};
use crate::emission::{rebuild_emission, with_emission_apart};
use crate::method::{Fit, Method, MethodSettings};
use crate::network::WeightsError;
use crate::prefilter::{FeatureSet, prefilter};
use crate::reconstruction::{ReconstructError, Reconstruction};
use crate::rivals::Rival;
use crate::rivals::lbf::Tuning;
use crate::rivals::wlr::Variant;
use crate::{Settings, best, paper, rivals};

/// Reconstructs the picture of `stack`: every component by itself, then their sum.
///
/// # Errors
/// When a feature does not fit its role or the stack, or `monitor` cancels.
pub fn reconstruct(
    stack: &FeatureStack,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let Completed { stack, lacks } = complete(stack, &settings.completion, monitor)?;
    Ok(Reconstruction { lacks, ..by_method(&stack, settings, monitor)? })
}

fn by_method(
    stack: &FeatureStack,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    match settings.method.method {
        Method::Ld => sum_of_components(stack.size(), &stack.components, |component| unfiltered(stack, component)),
        Method::Ours => ours(stack, settings, monitor),
        Method::Wlr => rivals::reconstruct(stack, Rival::Wlr(Variant::Plain), settings, monitor),
        Method::Wlrp => rivals::reconstruct(stack, Rival::Wlr(Variant::Pilot), settings, monitor),
        Method::Wlrv => rivals::reconstruct(stack, Rival::Wlr(Variant::Visibility), settings, monitor),
        Method::Nfor => rivals::reconstruct(stack, Rival::Nfor, settings, monitor),
        Method::Apr => rivals::reconstruct(stack, Rival::Apr, settings, monitor),
        Method::Lbf => rivals::reconstruct(stack, Rival::Lbf(Tuning::Trained), settings, monitor),
    }
}

/// The same, but frees the buckets of `stack` as soon as nothing needs them; means and sample counts stay.
///
/// # Errors
/// As [`reconstruct`].
pub fn reconstruct_freeing(
    stack: &mut FeatureStack,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let MethodSettings { method, fit } = settings.method;
    if (method, fit) != (Method::Ours, Fit::Collaborative) {
        return reconstruct(stack, settings, monitor);
    }
    let Completed { stack: completed, lacks } = complete(stack, &settings.completion, monitor)?;
    let made_up = match completed {
        Cow::Borrowed(_) => None,
        Cow::Owned(completed) => Some(completed),
    };
    let rebuilt = match made_up {
        None => freeing(stack, settings, monitor)?,
        Some(mut completed) => freeing(&mut completed, settings, monitor)?,
    };
    Ok(Reconstruction { lacks, ..rebuilt })
}

fn freeing(
    stack: &mut FeatureStack,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let features = best::guide_features(stack, &settings.best.features, monitor)?;
    stack.features.iter_mut().for_each(|feature| feature.estimate.noise = Noise::Unknown);
    let mut components = with_noise_of(&mut stack.components);
    let chooser = chooser(settings)?;
    let task = Collaborative { stack, features: &features, settings, chooser: chooser.as_ref() };
    let mut sum = Reconstruction::plain(Image::zeros(stack.size(), 3));
    // The last first: emission is soon done with.
    while let Some(component) = components.pop() {
        if is_lit(&component) {
            sum.add(task.rebuilt(Cow::Owned(component), monitor)?);
        }
    }
    Ok(sum)
}

/// Copies of `components` that take over what is known about their noise.
fn with_noise_of(components: &mut [Component]) -> Vec<Component> {
    let taken = |component: &mut Component| {
        let noise = std::mem::replace(&mut component.radiance.noise, Noise::Unknown);
        Component { role: component.role, radiance: Estimate { mean: component.radiance.mean.clone(), noise } }
    };
    components.iter_mut().map(taken).collect()
}

fn ours(stack: &FeatureStack, settings: &Settings, monitor: &dyn Monitor) -> Result<Reconstruction, ReconstructError> {
    match settings.method.fit {
        Fit::Local => {
            let features = prefilter(stack, &settings.prefilter, monitor)?;
            sum_of_components(stack.size(), &with_emission_apart(stack, monitor), |component| {
                rebuilt(stack, component, &features, settings, monitor)
            })
        }
        Fit::Collaborative => reconstruct_with_chooser(stack, settings, chooser(settings)?.as_ref(), monitor),
    }
}

/// Reconstructs the picture of `stack` by collaborative fits; the `chooser` helps to mix their candidates.
///
/// # Errors
/// As [`reconstruct`].
pub fn reconstruct_with_chooser(
    stack: &FeatureStack,
    settings: &Settings,
    chooser: Option<&Chooser>,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let features = best::guide_features(stack, &settings.best.features, monitor)?;
    let task = Collaborative { stack, features: &features, settings, chooser };
    sum_of_components(stack.size(), &stack.components, |component| task.rebuilt(Cow::Borrowed(component), monitor))
}

/// What the network says that comes along, where it is asked.
fn chooser(settings: &Settings) -> Result<Option<Chooser>, WeightsError> {
    settings.best.choice.learned.then(best::trained).transpose()
}

/// What collaborative fits need to rebuild a component.
struct Collaborative<'a> {
    stack: &'a FeatureStack,
    features: &'a GuideFeatures,
    settings: &'a Settings,
    chooser: Option<&'a Chooser>,
}

impl Collaborative<'_> {
    fn rebuilt(
        &self,
        component: Cow<'_, Component>,
        monitor: &dyn Monitor,
    ) -> Result<Reconstruction, ReconstructError> {
        let Self { stack, features, settings, chooser } = *self;
        if component.role == ComponentRole::Scattered {
            return best::rebuild(stack, component, features, &settings.best, chooser, monitor);
        }
        let (radiance, variance) = (&component.radiance.mean, variance_of(stack, &component)?);
        let mut rebuilt = rebuild_emission(radiance, &variance, &features.set, settings, monitor)?;
        best::share_unseen(&mut rebuilt.mse, &variance);
        Ok(rebuilt)
    }
}

/// The mean of the samples, with its variance as error.
fn unfiltered(stack: &FeatureStack, component: &Component) -> Result<Reconstruction, ReconstructError> {
    let variance = variance_of(stack, component)?;
    let mse = (0..variance.pixels()).map(|pixel| variance.mean_at(pixel)).collect();
    Ok(Reconstruction { mse, ..Reconstruction::plain(component.radiance.mean.clone()) })
}

fn rebuilt(
    stack: &FeatureStack,
    component: &Component,
    features: &FeatureSet,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let (radiance, variance) = (&component.radiance.mean, variance_of(stack, component)?);
    Ok(match component.role {
        ComponentRole::Scattered => paper::rebuild(radiance, &variance, features, settings, monitor)?,
        ComponentRole::Emission => rebuild_emission(radiance, &variance, features, settings, monitor)?,
    })
}
