//! A picture rebuilt from its stack: every component by the method that was asked for, then their sum.

use std::borrow::Cow;

use stack::{Component, ComponentRole, Estimate, FeatureStack, Image, Monitor, Noise};

use crate::best::GuideFeatures;
use crate::components::{is_lit, sum_of_components, variance_of};
use crate::emission::{rebuild_emission, with_emission_apart};
use crate::method::{Fit, Method, MethodSettings};
use crate::prefilter::{FeatureSet, prefilter};
use crate::reconstruction::{ReconstructError, Reconstruction};
use crate::rivals::Rival;
use crate::rivals::lbf::Tuning;
use crate::rivals::wlr::Variant;
use crate::{Settings, best, paper, rivals};

/// Reconstructs the picture of `stack`: every component by itself, then their sum.
///
/// # Errors
/// When the noise of a component is unknown, there is no feature, or `monitor` cancels.
pub fn reconstruct(
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
    let features = best::guide_features(stack, &settings.best.features, monitor)?;
    stack.features.iter_mut().for_each(|feature| feature.estimate.noise = Noise::Unknown);
    let mut components = with_noise_of(&mut stack.components);
    let mut sum = Reconstruction::plain(Image::zeros(stack.size(), 3));
    // The last first: emission is soon done with.
    while let Some(component) = components.pop() {
        if is_lit(&component) {
            sum.add(collaborative(stack, Cow::Owned(component), &features, settings, monitor)?);
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
        Fit::Collaborative => {
            let features = best::guide_features(stack, &settings.best.features, monitor)?;
            sum_of_components(stack.size(), &stack.components, |component| {
                collaborative(stack, Cow::Borrowed(component), &features, settings, monitor)
            })
        }
    }
}

fn collaborative(
    stack: &FeatureStack,
    component: Cow<'_, Component>,
    features: &GuideFeatures,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    if component.role == ComponentRole::Scattered {
        return best::rebuild(stack, component, features, &settings.best, monitor);
    }
    let (radiance, variance) = (&component.radiance.mean, variance_of(stack, &component)?);
    let mut rebuilt = rebuild_emission(radiance, &variance, &features.set, settings, monitor)?;
    best::share_unseen(&mut rebuilt.mse, &variance);
    Ok(rebuilt)
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
