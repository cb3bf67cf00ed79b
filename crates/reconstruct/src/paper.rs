//! The paper's method: features freed of noise, spikes replaced, one regression at every pixel (its figure 2).

#[cfg(test)]
mod alternatives;

use stack::{Cancelled, ComponentRole, FeatureStack, Image, Monitor};

use crate::Settings;
use crate::components::{sum_of_components, variance_of};
use crate::emission::{rebuild_emission, with_emission_apart};
use crate::prefilter::{FeatureSet, prefilter};
use crate::reconstruction::{ReconstructError, Reconstruction};
use crate::regression::{RegressionInput, regress};
use crate::spikes::{SpikeFree, remove_spikes};

/// Rebuilds the picture of `stack`. The paper knows scattered light only; directly seen emission is rebuilt by itself.
///
/// # Errors
/// When a feature does not fit its role or the stack, nothing is known about noise, or `monitor` cancels.
pub fn reconstruct(
    stack: &FeatureStack,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let features = prefilter(stack, &settings.prefilter, monitor)?;
    sum_of_components(stack.size(), &with_emission_apart(stack, monitor), |component| {
        let (radiance, variance) = (&component.radiance.mean, variance_of(component, &stack.samples)?);
        Ok(match component.role {
            ComponentRole::Scattered => rebuild_scattered(radiance, &variance, &features, settings, monitor)?,
            ComponentRole::Emission => rebuild_emission(radiance, &variance, &features, &settings.regression, monitor)?,
        })
    })
}

/// Rebuilds scattered light: `radiance`, three channels, with the `variance` of its mean, by prefiltered `features`.
fn rebuild_scattered(
    radiance: &Image,
    variance: &Image,
    features: &FeatureSet,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, Cancelled> {
    let SpikeFree { colour, variance, spikes, marked } = remove_spikes(radiance, variance, &settings.spikes, monitor)?;
    let input = RegressionInput { colour: &colour, variance: &variance, features, active: None };
    let regression = regress(&input, &settings.regression, monitor)?;
    Ok(Reconstruction {
        mse: regression.mse,
        spikes: Some(spikes),
        marked: marked.iter().filter(|marked| **marked).count(),
        bandwidth: Some(regression.bandwidth),
        rank: Some(regression.rank),
        ..Reconstruction::plain(regression.picture)
    })
}
