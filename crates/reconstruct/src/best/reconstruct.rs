//! A whole stack: its components one by one, in light of usual brightness, direct and indirect light apart where that is
//! better.

use std::borrow::Cow;

use stack::{Component, ComponentRole, FeatureStack, Image, Monitor};

use super::by_component::Components;
use super::choice::Chooser;
use super::features::{clean_features, clean_features_freeing};
use super::indirect::{IndirectLight, Light};
use super::recipe::Extras;
use crate::Settings;
use crate::components::{is_lit, sum_of_components};
use crate::exposure::exposure;
use crate::reconstruction::{ReconstructError, Reconstruction};

/// Rebuilds the picture of a complete `stack`; the `chooser` helps to mix candidates, where there is one.
///
/// # Errors
/// When a feature does not fit its role or the stack, nothing is known about noise, the network would be asked about
/// candidates that it does not know, or `monitor` cancels.
pub fn reconstruct(
    stack: &FeatureStack,
    settings: &Settings,
    chooser: Option<&Chooser>,
    extras: Extras,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let light = &settings.best.light;
    let features = clean_features(stack, &settings.best, monitor)?;
    let exposure = exposure(&stack.components, light.usual_brightness());
    let components = Components::new(&stack.samples, &features, settings, chooser, extras, exposure)?;
    sum_of_components(stack.size(), &stack.components, |component| {
        let indirect = IndirectLight::of(stack, light.gathered).filter(|_| may_go_apart(component, extras));
        let light = Light::of(Cow::Borrowed(component), indirect, &stack.samples, light, exposure);
        components.rebuilt(light, monitor)
    })
}

/// The same, but frees what no step needs any more.
///
/// # Errors
/// As [`reconstruct`].
pub fn reconstruct_freeing(
    mut stack: FeatureStack,
    settings: &Settings,
    chooser: Option<&Chooser>,
    extras: Extras,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let light = &settings.best.light;
    let components = std::mem::take(&mut stack.components);
    let exposure = exposure(&components, light.usual_brightness());
    let mut indirect = IndirectLight::taken_from(&mut stack, light.gathered);
    // Taken apart before anything is made of it: the parts are less than what they are made from.
    let mut lights = Vec::new();
    for component in components.into_iter().filter(is_lit) {
        let indirect = if may_go_apart(&component, extras) { indirect.take() } else { None };
        lights.push(Light::of(Cow::Owned(component), indirect, &stack.samples, light, exposure));
    }
    drop(indirect);
    let features = clean_features_freeing(&mut stack, &settings.best, monitor)?;
    let components = Components::new(&stack.samples, &features, settings, chooser, extras, exposure)?;
    let mut sum = Reconstruction::plain(Image::zeros(stack.size(), 3));
    // The last first: emission is soon done with.
    while let Some(light) = lights.pop() {
        sum.add(components.rebuilt(light, monitor)?);
    }
    Ok(sum)
}

/// Whether indirect light may be taken off `component`. Passes need the weights of the whole as it was found.
fn may_go_apart(component: &Component, extras: Extras) -> bool {
    component.role == ComponentRole::Scattered && extras.passes.is_empty()
}
