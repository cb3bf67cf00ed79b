//! A picture rebuilt from its stack: every component by the method that was asked for, then their sum.

use stack::{Component, ComponentRole, FeatureStack, Monitor};

use crate::completion::{Completed, complete};
use crate::components::{sum_of_components, variance_of};
use crate::emission::{rebuild_emission, with_emission_apart};
use crate::method::{Fit, Method};
use crate::prefilter::{FeatureSet, prefilter};
use crate::reconstruction::{ReconstructError, Reconstruction};
use crate::rivals::Rival;
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
    }
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
            sum_of_components(stack.size(), &stack.components, |component| match component.role {
                ComponentRole::Scattered => best::rebuild(stack, component, &features, &settings.best, monitor),
                ComponentRole::Emission => {
                    let (radiance, variance) = (&component.radiance.mean, variance_of(stack, component)?);
                    let mut rebuilt = rebuild_emission(radiance, &variance, &features.set, settings, monitor)?;
                    best::share_unseen(&mut rebuilt.mse, &variance);
                    Ok(rebuilt)
                }
            })
        }
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
