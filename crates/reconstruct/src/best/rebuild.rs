//! The whole way of a component of scattered light.

use std::borrow::Cow;

use stack::{Component, Image, Monitor};

use super::clouds::without_clouds;
use super::edge_avoiding::EdgeAvoidingKernel;
use super::error::estimated_error;
use super::halves::{mean_of, sum_of};
use super::passes::add_up_to;
use super::piloted::Piloted;
use super::recipe::Recipe;
use super::restore::Loss;
use super::second_half::second_half;
use super::settings::{ChoiceSettings, RestoreSettings};
use crate::reconstruction::{ReconstructError, Reconstruction};

/// Rebuilds the scattered light `component`. One that is owned is freed as soon as nothing needs it.
///
/// # Errors
/// When nothing is known about its noise, or `monitor` cancels.
pub fn rebuild(
    recipe: &Recipe,
    component: Cow<'_, Component>,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let (piloted, events) = Piloted::new(recipe, component, monitor)?;
    let (halves, passes) = second_half(recipe, &piloted, monitor)?;
    let mut picture = cleared_and_restored(&halves, &piloted, recipe, monitor)?;
    picture.add(&events.light);
    picture.channels_mut().iter_mut().flatten().for_each(|v| *v = v.max(0.0));
    let ChoiceSettings { feature_scale, brightness, .. } = recipe.settings.choice;
    let kernel = EdgeAvoidingKernel::on_surfaces_of_like_brightness(
        piloted.separating_features(),
        &piloted.pilot,
        feature_scale,
        brightness,
    );
    Ok(Reconstruction {
        mse: estimated_error(&halves, &events.variance, &picture, &kernel, &recipe.settings.error),
        spikes: Some(sum_of(&events.cut.light)),
        marked: events.cut.energy.iter().filter(|e| **e > 0.0).count(),
        passes: add_up_to(passes, &picture),
        ..Reconstruction::plain(picture)
    })
}

/// The mean of the rebuilt `halves` without clouds of noise, and with the light that the regressions lost.
fn cleared_and_restored(
    halves: &[Image; 2],
    piloted: &Piloted,
    recipe: &Recipe,
    monitor: &dyn Monitor,
) -> Result<Image, ReconstructError> {
    let settings = recipe.settings;
    let mean = mean_of(halves);
    let RestoreSettings { feature_scale, brightness, .. } = settings.restore;
    let kernel = EdgeAvoidingKernel::on_surfaces_of_like_brightness(
        piloted.separating_features(),
        &mean,
        feature_scale,
        brightness,
    );
    let mut loss = Loss::new(&mean, &piloted.given.low.halves, &kernel, &settings.restore);
    let mut picture = without_clouds(mean, halves, |step| loss.taps(step), &settings.clouds, monitor)?;
    loss.give_back(&mut picture);
    Ok(picture)
}
