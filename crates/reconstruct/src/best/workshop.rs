//! The whole way of a component, in whatever portions.

use std::borrow::Cow;

use stack::{Cancelled, Component, FeatureStack, Image, Monitor};

use super::choice::{self, Chooser, mixtures};
use super::clouds::without_clouds;
use super::error;
use super::features::GuideFeatures;
use super::guided_kernel::GuidedKernel;
use super::halves::{mean_of, sum_of};
use super::passes::add_up_to;
use super::piloted::Piloted;
use super::restore::Loss;
use super::second_pass;
use super::settings::{BestSettings, ChoiceSettings, RestoreSettings};
use crate::bands::bands;
use crate::collaborative::period;
use crate::reconstruction::{ReconstructError, Reconstruction};

/// What a component is rebuilt with.
#[derive(Clone, Copy)]
pub struct Workshop<'a> {
    /// Where it comes from.
    pub stack: &'a FeatureStack,
    /// What explains it.
    pub features: &'a GuideFeatures,
    /// Light of the same picture that was rebuilt before, where it says where there is likely more of the rest.
    pub beside: Option<&'a Image>,
    /// How.
    pub settings: &'a BestSettings,
    /// What helps to mix candidates, where the settings ask for it.
    pub chooser: Option<&'a Chooser>,
    /// What is asked beside the picture.
    pub extras: Extras<'a>,
}

/// What is asked beside the picture, and how it is worked on.
#[derive(Clone, Copy, Debug)]
pub struct Extras<'a> {
    /// Rows of the second pass that are made at once: fewer need less memory and more time, the picture is the same.
    pub rows: usize,
    /// Parts of the scattered light that are rebuilt with its weights; of as many pixels, with three channels.
    pub passes: &'a [Image],
}

impl Default for Extras<'_> {
    fn default() -> Self {
        Self { rows: usize::MAX, passes: &[] }
    }
}

impl Workshop<'_> {
    /// Rebuilds the scattered light `component`. One that it owns is freed as soon as nothing needs it.
    ///
    /// # Errors
    /// When its noise does not come in buckets, or `monitor` cancels.
    pub fn rebuild(
        &self,
        component: Cow<'_, Component>,
        monitor: &dyn Monitor,
    ) -> Result<Reconstruction, ReconstructError> {
        let settings = self.settings;
        let (stack, features, passes) = (self.stack, self.features, self.extras.passes);
        let piloted = Piloted::new(stack, component, features, self.beside, settings, passes, monitor)?;
        let (halves, passes) = self.second_half(&piloted, monitor)?;
        let surfaces = piloted.surfaces();
        let mean = mean_of(&halves);
        let RestoreSettings { feature_scale, brightness, .. } = settings.restore;
        let kernel = GuidedKernel::surfaces_and_brightness(surfaces, &mean, feature_scale, brightness);
        let mut loss = Loss::new(&mean, &piloted.layers.halves, &kernel, &settings.restore);
        let mut picture = without_clouds(mean, &halves, |step| loss.taps(step), &settings.clouds, monitor)?;
        loss.give_back(&mut picture);
        picture.add(&piloted.spread);
        picture.channels_mut().iter_mut().flatten().for_each(|v| *v = v.max(0.0));
        let ChoiceSettings { feature_scale, brightness, .. } = settings.choice;
        let kernel = GuidedKernel::surfaces_and_brightness(surfaces, &piloted.pilot, feature_scale, brightness);
        let events = &piloted.layers.events;
        Ok(Reconstruction {
            mse: error::estimated_error(&halves, &piloted.event_variance, &picture, &kernel, &settings.error),
            spikes: Some(sum_of(&events.light)),
            marked: events.energy.iter().filter(|e| **e > 0.0).count(),
            passes: add_up_to(passes, &picture),
            ..Reconstruction::plain(picture)
        })
    }

    /// The second pass and the choice, band by band: both halves of the low layer, and the passes.
    fn second_half(&self, piloted: &Piloted, monitor: &dyn Monitor) -> Result<([Image; 2], Vec<Image>), Cancelled> {
        let fit = &self.settings.regression;
        if fit.passes < 2 {
            let passes = piloted.passes.iter().map(|pass| pass.first.clone());
            return Ok((piloted.first.clone(), passes.collect()));
        }
        let (size, period) = (piloted.pilot.size(), period(fit.stride));
        let margin = (second_pass::reach(fit) + choice::REACH).next_multiple_of(period);
        let rows = self.extras.rows.clamp(1, size.height.max(1)).next_multiple_of(period);
        let black = || Image::zeros(size, 3);
        let mut halves = [black(), black()];
        let mut passes: Vec<Image> = piloted.passes.iter().map(|_| black()).collect();
        for band in bands(size.height, rows, margin) {
            let part = match band.is_whole(size.height) {
                true => Cow::Borrowed(piloted),
                false => Cow::Owned(piloted.rows(&band.around)),
            };
            let (some_halves, some_passes) = self.second_half_at_once(&part, monitor)?;
            let made = some_halves.iter().chain(&some_passes);
            made.zip(halves.iter_mut().chain(&mut passes)).for_each(|(made, whole)| band.put(made, whole));
        }
        Ok((halves, passes))
    }

    fn second_half_at_once(
        &self,
        piloted: &Piloted,
        monitor: &dyn Monitor,
    ) -> Result<([Image; 2], Vec<Image>), Cancelled> {
        let fit = &self.settings.regression;
        let candidates = piloted.candidates(&piloted.layers.halves, &piloted.first, fit, monitor)?;
        monitor.begin("choice", 1);
        let chooser = self.chooser.filter(|_| self.settings.choice.learned);
        let weights = choice::weights(&piloted.contest(&candidates), &self.settings.choice, chooser);
        let halves = mixtures(&candidates, weights.channels());
        drop(candidates);
        let mut passes = Vec::new();
        for pair in piloted.passes.chunks(2) {
            let both = [&pair[0], pair.last().unwrap_or(&pair[0])];
            let (low, first) = (both.map(|pass| pass.low.clone()), both.map(|pass| pass.first.clone()));
            let candidates = piloted.candidates(&low, &first, fit, monitor)?;
            passes.extend(mixtures(&candidates, weights.channels()).into_iter().take(pair.len()));
        }
        Ok((halves, passes))
    }
}
