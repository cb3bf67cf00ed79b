//! Published methods to compare ours with, on the same stacks.
//!
//! Each looks at the samples as ours does: means, half-buffers and variances of radiance and features. What a paper
//! leaves open follows its authors' own program, as far as that is public. Directly seen emission is no matter of these
//! papers: it is a component of its own and rebuilt as it is for ours.

pub mod apr;
pub mod lbf;
mod measured_features;
pub mod nfor;
pub mod wlr;

use std::borrow::Cow;

use stack::{Component, ComponentRole, FeatureStack, Monitor};

use crate::Settings;
use crate::components::{sum_of_components, variance_of};
use crate::emission::{rebuild_emission, with_emission_apart};
use crate::prefilter::prefilter;
use crate::reconstruction::{ReconstructError, Reconstruction};

/// A published method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rival<'a> {
    /// Weighted local regression.
    Wlr(wlr::Variant),
    /// Nonlinearly weighted first-order regression.
    Nfor {
        /// Whether the noise was measured, rather than told from the picture.
        noise_measured: bool,
    },
    /// Adaptive polynomial rendering.
    Apr,
    /// The learning-based filter.
    Lbf(lbf::Tuning<'a>),
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
    // A collaborative fit follows lamps by itself; elsewhere their bright edges would spoil the fits around them.
    let components = match rival {
        Rival::Nfor { .. } => Cow::Borrowed(stack.components.as_slice()),
        Rival::Wlr(_) | Rival::Apr | Rival::Lbf(_) => with_emission_apart(stack, monitor),
    };
    sum_of_components(stack.size(), &components, |component| match component.role {
        ComponentRole::Scattered => scattered(stack, component, rival, settings, monitor),
        ComponentRole::Emission => {
            let features = prefilter(stack, &settings.prefilter, monitor)?;
            let variance = variance_of(component, &stack.samples)?;
            Ok(rebuild_emission(&component.radiance.mean, &variance, &features, &settings.regression, monitor)?)
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
    let (radiance, variance) = (&component.radiance.mean, variance_of(component, &stack.samples)?);
    match rival {
        Rival::Wlr(variant) => wlr::rebuild(stack, radiance, &variance, variant, settings, monitor),
        Rival::Nfor { noise_measured } => nfor::rebuild(stack, component, noise_measured, settings, monitor),
        Rival::Apr => apr::rebuild(stack, radiance, &variance, settings, monitor),
        Rival::Lbf(tuning) => lbf::rebuild(stack, radiance, &variance, tuning, settings, monitor),
    }
}
