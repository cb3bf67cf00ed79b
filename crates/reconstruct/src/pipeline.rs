//! A picture rebuilt from its stack: every component by the method that was asked for, then their sum.

use std::borrow::Cow;

use stack::{Component, ComponentRole, FeatureStack, Image, Monitor};

use crate::best::{Chooser, Extras};
use crate::by_component::Collaborative;
use crate::completion::{Completed, complete};
use crate::components::{is_lit, sum_of_components, variance_of};
use crate::emission::{rebuild_emission, with_emission_apart};
use crate::exposure::exposure;
use crate::indirect::{IndirectLight, Light};
use crate::method::Method;
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
    reconstruct_with(stack, settings, Extras::default(), monitor)
}

/// The same, with `extras`.
///
/// # Errors
/// As [`reconstruct`], and when passes are asked of a method that has none.
pub fn reconstruct_with(
    stack: &FeatureStack,
    settings: &Settings,
    extras: Extras,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let Completed { stack, lacks } = complete(Cow::Borrowed(stack), &settings.completion_for_method(), monitor)?;
    let rebuilt = if settings.method.is_collaborative() {
        collaborative(&stack, settings, chooser(settings)?.as_ref(), extras, monitor)?
    } else if extras.passes.is_empty() {
        by_method(&stack, settings, monitor)?
    } else {
        return Err(ReconstructError::NoPasses);
    };
    Ok(Reconstruction { lacks, ..rebuilt })
}

fn by_method(
    stack: &FeatureStack,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    match settings.method.method {
        Method::Ld => sum_of_components(stack.size(), &stack.components, |component| unfiltered(stack, component)),
        Method::Ours => local(stack, settings, monitor),
        Method::Wlr => rivals::reconstruct(stack, Rival::Wlr(Variant::Plain), settings, monitor),
        Method::Wlrp => rivals::reconstruct(stack, Rival::Wlr(Variant::Pilot), settings, monitor),
        Method::Wlrv => rivals::reconstruct(stack, Rival::Wlr(Variant::Visibility), settings, monitor),
        Method::Nfor => rivals::reconstruct(stack, Rival::Nfor, settings, monitor),
        Method::Apr => rivals::reconstruct(stack, Rival::Apr, settings, monitor),
        Method::Lbf => rivals::reconstruct(stack, Rival::Lbf(Tuning::Trained), settings, monitor),
    }
}

/// The same, but frees the `stack` as soon as nothing needs it: of its components and features nothing is left.
///
/// # Errors
/// As [`reconstruct_with`].
pub fn reconstruct_freeing(
    stack: &mut FeatureStack,
    settings: &Settings,
    extras: Extras,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    if !settings.method.is_collaborative() {
        return reconstruct_with(stack, settings, extras, monitor);
    }
    let completed = complete(Cow::Owned(taken_from(stack)), &settings.completion_for_method(), monitor)?;
    let rebuilt = freeing(completed.stack.into_owned(), settings, extras, monitor)?;
    Ok(Reconstruction { lacks: completed.lacks, ..rebuilt })
}

/// What is rebuilt of `stack`, which keeps the rest.
fn taken_from(stack: &mut FeatureStack) -> FeatureStack {
    FeatureStack {
        window: stack.window,
        film: stack.film,
        samples: stack.samples.clone(),
        components: std::mem::take(&mut stack.components),
        indirect: stack.indirect.take(),
        gathered: stack.gathered.take(),
        features: std::mem::take(&mut stack.features),
        passthrough: Vec::new(),
    }
}

/// Frees what no step needs any more.
fn freeing(
    mut stack: FeatureStack,
    settings: &Settings,
    extras: Extras,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let components = std::mem::take(&mut stack.components);
    let exposure = exposure(&components, &settings.best.light);
    let mut indirect = IndirectLight::taken_from(&mut stack, settings.best.light.gathered);
    // Taken apart before anything is made of it: the parts are less than what they are made from.
    let mut lights = Vec::new();
    for component in components.into_iter().filter(is_lit) {
        let indirect = if component.role == ComponentRole::Scattered { indirect.take() } else { None };
        lights.push(light(Cow::Owned(component), indirect, &stack, settings, extras, exposure));
    }
    drop(indirect);
    let features = best::guide_features_freeing(&mut stack, &settings.best, monitor)?;
    let chooser = chooser(settings)?;
    let task = Collaborative::new(&stack, &features, settings, chooser.as_ref(), extras, exposure)?;
    let mut sum = Reconstruction::plain(Image::zeros(stack.size(), 3));
    // The last first: emission is soon done with.
    while let Some(light) = lights.pop() {
        sum.add(task.rebuilt(light, monitor)?);
    }
    Ok(sum)
}

/// How `component` is rebuilt, of which there may be `indirect` light. Passes need the weights of the whole as it was found.
fn light<'a>(
    component: Cow<'a, Component>,
    indirect: Option<IndirectLight>,
    stack: &FeatureStack,
    settings: &Settings,
    extras: Extras,
    exposure: f32,
) -> Light<'a> {
    let is_scattered = component.role == ComponentRole::Scattered;
    match indirect.filter(|_| is_scattered && extras.passes.is_empty()) {
        Some(indirect) => indirect.of_whole(component, &stack.samples, &settings.best.light, exposure),
        None => Light::Whole(component),
    }
}

/// The paper's method.
fn local(stack: &FeatureStack, settings: &Settings, monitor: &dyn Monitor) -> Result<Reconstruction, ReconstructError> {
    let features = prefilter(stack, &settings.prefilter, monitor)?;
    sum_of_components(stack.size(), &with_emission_apart(stack, monitor), |component| {
        rebuilt(stack, component, &features, settings, monitor)
    })
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
    collaborative(stack, settings, chooser, Extras::default(), monitor)
}

fn collaborative(
    stack: &FeatureStack,
    settings: &Settings,
    chooser: Option<&Chooser>,
    extras: Extras,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let features = best::guide_features(stack, &settings.best, monitor)?;
    let exposure = exposure(&stack.components, &settings.best.light);
    let task = Collaborative::new(stack, &features, settings, chooser, extras, exposure)?;
    sum_of_components(stack.size(), &stack.components, |component| {
        let indirect = IndirectLight::of(stack, settings.best.light.gathered);
        task.rebuilt(light(Cow::Borrowed(component), indirect, stack, settings, extras, exposure), monitor)
    })
}

/// What the network says that comes along, where it is asked.
fn chooser(settings: &Settings) -> Result<Option<Chooser>, WeightsError> {
    settings.best.choice.learned.then(best::trained).transpose()
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
