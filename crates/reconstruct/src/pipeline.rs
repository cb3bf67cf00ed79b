//! The way in: what a stack lacks is made up, then the method that was asked for rebuilds its picture.

use std::borrow::Cow;

use stack::{FeatureStack, Monitor};

use crate::best::{Chooser, Extras};
use crate::completion::{Completed, complete};
use crate::components::{sum_of_components, variance_of};
use crate::lack::Lack;
use crate::method::Method;
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
        let chooser = best::chooser_of(&settings.best.choice)?;
        best::reconstruct(&stack, settings, chooser.as_ref(), extras, monitor)?
    } else if extras.passes.is_empty() {
        by_method(&stack, &lacks, settings, monitor)?
    } else {
        return Err(ReconstructError::NoPasses);
    };
    Ok(Reconstruction { lacks, ..rebuilt })
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
    let chooser = best::chooser_of(&settings.best.choice)?;
    let rebuilt = best::reconstruct_freeing(completed.stack.into_owned(), settings, chooser.as_ref(), extras, monitor)?;
    Ok(Reconstruction { lacks: completed.lacks, ..rebuilt })
}

/// Reconstructs the picture of a complete `stack` by collaborative fits; this `chooser` helps to mix their candidates.
///
/// # Errors
/// As [`reconstruct`].
pub fn reconstruct_with_chooser(
    stack: &FeatureStack,
    settings: &Settings,
    chooser: Option<&Chooser>,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    best::reconstruct(stack, settings, chooser, Extras::default(), monitor)
}

/// All methods but the collaborative one, which knows more than the others' arguments say. The stack was completed where it
/// `lacks` something.
fn by_method(
    stack: &FeatureStack,
    lacks: &[Lack],
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let rival = match settings.method.method {
        Method::Ld => return unfiltered(stack),
        Method::Ours => return paper::reconstruct(stack, settings, monitor),
        Method::Wlr => Rival::Wlr(Variant::Plain),
        Method::Wlrp => Rival::Wlr(Variant::Pilot),
        Method::Wlrv => Rival::Wlr(Variant::Visibility),
        Method::Nfor => Rival::Nfor { noise_measured: !lacks.contains(&Lack::NOISE) },
        Method::Apr => Rival::Apr,
        Method::Lbf => Rival::Lbf(Tuning::Trained),
    };
    rivals::reconstruct(stack, rival, settings, monitor)
}

/// The mean of the samples, with its variance as error.
fn unfiltered(stack: &FeatureStack) -> Result<Reconstruction, ReconstructError> {
    sum_of_components(stack.size(), &stack.components, |component| {
        let variance = variance_of(component, &stack.samples)?;
        let mse = (0..variance.pixels()).map(|pixel| variance.mean_at(pixel)).collect();
        Ok(Reconstruction { mse, ..Reconstruction::plain(component.radiance.mean.clone()) })
    })
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
