//! Published methods to compare ours with, on the same stacks.
//!
//! Each looks at the samples as ours does: means, half-buffers and variances of radiance and features. What a paper
//! leaves open follows its authors' own program, as far as that is public. Directly seen emission is no matter of these
//! papers: it is a component of its own and rebuilt as it is for ours.

pub mod apr;
mod guides;
pub mod wlr;

use stack::{Component, ComponentRole, FeatureStack, Monitor};

use crate::Settings;
use crate::emission::rebuild_emission;
use crate::pipeline::{ReconstructError, Reconstruction, sum_of_components, variance_of};
use crate::prefilter::prefilter;

/// A published method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rival {
    /// Weighted local regression.
    Wlr(wlr::Variant),
    /// Adaptive polynomial rendering.
    Apr,
}

/// Rebuilds `stack` by the method `rival`.
///
/// # Errors
/// When the noise of a component is unknown, there is no feature, or `monitor` cancels.
pub fn reconstruct(
    stack: &FeatureStack,
    rival: Rival,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    sum_of_components(stack, |component| match component.role {
        ComponentRole::Scattered => scattered(stack, component, rival, settings, monitor),
        ComponentRole::Emission => {
            let features = prefilter(stack, &settings.prefilter, monitor)?;
            let variance = variance_of(stack, component)?;
            Ok(rebuild_emission(&component.radiance.mean, &variance, &features, settings, monitor)?)
        }
    })
}

fn scattered(
    stack: &FeatureStack,
    component: &Component,
    rival: Rival,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let (radiance, variance) = (&component.radiance.mean, variance_of(stack, component)?);
    match rival {
        Rival::Wlr(variant) => wlr::rebuild(stack, radiance, &variance, variant, settings, monitor),
        Rival::Apr => apr::rebuild(stack, radiance, &variance, settings, monitor),
    }
}
