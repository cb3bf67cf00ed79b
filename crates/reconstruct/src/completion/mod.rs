//! What a stack lacks, made up from what it has, so that every method can rebuild any stack.
//!
//! Most renderers' files say nothing about noise, and many hold no position. Steps, one file each: without albedo the
//! picture itself, freed of noise (`picture`), tells textures, everywhere or on mirrors (`mirrors`); positions come from
//! depth or, without it, from the screen (`place`); where nothing is known about the noise of colour it is measured on the
//! picture (`noise`), by what a local fit (`local_fit`) leaves of each pixel. [`crate::recorruption`] makes half-buffers of a
//! mean and its variance.

mod local_fit;
mod mirrors;
mod noise;
mod picture;
mod place;
mod roughness;

use std::borrow::Cow;

use rayon::prelude::*;
use stack::{Component, Estimate, Feature, FeatureRole, FeatureStack, Image, Monitor, Noise, SampleCounts};

use crate::lack::Lack;
use crate::prefilter::{PrefilterError, check};
use mirrors::surfaces_without_texture;
use noise::measured_variance;
use picture::without_noise;
pub(crate) use place::has_depth;
use place::{position_from_depth, position_on_screen};
use roughness::roughness;

stack::knobs! {
    /// How what a stack lacks is made up.
    pub struct CompletionSettings("completion") {
        /// Radius of the windows in which noise is what a local fit does not explain, in pixels.
        noise_radius: usize = 2, 1..=8;
        /// Pixels whose features differ by more than this are left out of such a fit.
        noise_likeness: f32 = 0.1, 0.001..=100.0;
        /// Ridge of such a fit.
        noise_ridge: f32 = 1e-3, 1e-9..=10.0;
        /// Noise is at most this multiple of how rough the picture is along its smoothest direction.
        noise_roughness: f32 = 2.0, 0.0..=1e6;
        /// The same where no feature may explain detail.
        colour_roughness: f32 = 0.8, 0.0..=1e6;
        /// Multiple of the measured noise that is taken out of a picture which stands in for features; 0 leaves it out.
        picture_noise: f32 = 1.2, 0.0..=100.0;
        /// Whether such a picture also stands in for albedo that says nothing, on mirrors, glass and polished metal, where
        /// features stop at them.
        mirrors: bool = true, ..;
        /// Multiple of a feature's roughness that is taken for its variance.
        feature_roughness: f32 = 0.5, 0.0..=1000.0;
    }
}

/// A stack that has all that a reconstruction needs, and what it had to do without.
#[derive(Clone, Debug)]
pub struct Completed<'a> {
    /// The stack, with a position and with noise of known variance.
    pub stack: Cow<'a, FeatureStack>,
    /// What was made up.
    pub lacks: Vec<Lack>,
}

/// Completes `stack`: it comes back as it is where it lacks nothing. Reports the stage `completion`.
///
/// # Errors
/// When a feature does not fit its role or the stack.
pub fn complete<'a>(
    stack: Cow<'a, FeatureStack>,
    settings: &CompletionSettings,
    monitor: &dyn Monitor,
) -> Result<Completed<'a>, PrefilterError> {
    monitor.begin("completion", 1);
    let mut completed = Completed { stack, lacks: Vec::new() };
    completed.forget_lone_samples();
    if completed.stack.features.is_empty() {
        completed.lacks.push(Lack::FEATURES);
    }
    if settings.picture_noise > 0.0 {
        match completed.stack.feature(FeatureRole::Albedo) {
            Some(_) => completed.show_mirrored(settings)?,
            None => completed.add_picture(settings),
        }
    }
    completed.measure_features(settings);
    if completed.stack.feature(FeatureRole::Position).is_none() {
        completed.add_position(settings)?;
    }
    completed.measure_noise(settings)?;
    completed.lacks.iter().for_each(|lack| monitor.note(&lack.to_string()));
    Ok(completed)
}

impl Completed<'_> {
    /// Buckets of which most pixels have but one with samples say nothing about noise, as in a render of one sample a pixel.
    fn forget_lone_samples(&mut self) {
        let of_features = self.stack.features.iter().map(|feature| &feature.estimate);
        let estimates = self.stack.components.iter().map(|component| &component.radiance).chain(of_features);
        let mut lone: Vec<usize> = estimates.filter_map(buckets).collect();
        lone.sort_unstable();
        lone.dedup();
        lone.retain(|buckets| are_lone(&self.stack.samples, *buckets));
        if lone.is_empty() {
            return;
        }
        let stack = self.stack.to_mut();
        let of_features = stack.features.iter_mut().map(|feature| &mut feature.estimate);
        let estimates = stack.components.iter_mut().map(|component| &mut component.radiance).chain(of_features);
        for estimate in estimates.filter(|estimate| buckets(estimate).is_some_and(|buckets| lone.contains(&buckets))) {
            estimate.noise = Noise::Unknown;
        }
    }

    /// Where no albedo tells textures, the picture itself does, freed of noise.
    fn add_picture(&mut self, settings: &CompletionSettings) {
        let everywhere = vec![true; self.stack.size().pixels()];
        let Some(mean) = without_noise(&self.stack.beauty(), &everywhere, settings.picture_noise) else { return };
        self.lacks_feature(Lack::ALBEDO);
        let after_position = usize::from(self.stack.feature(FeatureRole::Position).is_some());
        let estimate = Estimate { mean, noise: Noise::Unknown };
        self.stack.to_mut().features.insert(after_position, Feature { role: FeatureRole::Albedo, estimate });
    }

    /// Where albedo says nothing because a surface mirrors or refracts, the picture does, freed of noise. A renderer that tells
    /// of next surfaces has followed the light to where albedo does.
    fn show_mirrored(&mut self, settings: &CompletionSettings) -> Result<(), PrefilterError> {
        let follows = self.stack.features.iter().any(|feature| feature.role.is_of_next_surface());
        let feature = |role| self.stack.feature(role);
        let (Some(albedo), Some(normal)) = (feature(FeatureRole::Albedo), feature(FeatureRole::Normal)) else {
            return Ok(());
        };
        if follows || !settings.mirrors {
            return Ok(());
        }
        check(albedo, self.stack.size())?;
        check(normal, self.stack.size())?;
        let marks = surfaces_without_texture(&albedo.estimate.mean, &normal.estimate.mean);
        if !marks.contains(&true) {
            return Ok(());
        }
        let Some(picture) = without_noise(&self.stack.beauty(), &marks, settings.picture_noise) else { return Ok(()) };
        let mut mean = albedo.estimate.mean.clone();
        replace(&mut mean, &picture, &marks);
        let noise = match albedo.estimate.variance_of_mean(&self.stack.samples) {
            Some(mut variance) => {
                replace(&mut variance, &measured_roughness(&picture, settings), &marks);
                Noise::VarianceOfMean(variance)
            }
            None => Noise::Unknown,
        };
        let mut features = self.stack.to_mut().features.iter_mut();
        if let Some(feature) = features.find(|feature| feature.role == FeatureRole::Albedo) {
            feature.estimate = Estimate { mean, noise };
        }
        self.lacks.push(Lack::MIRRORED);
        Ok(())
    }

    /// Tells of one feature, unless it was told that there is none.
    fn lacks_feature(&mut self, lack: Lack) {
        if !self.lacks.contains(&Lack::FEATURES) {
            self.lacks.push(lack);
        }
    }

    fn add_position(&mut self, settings: &CompletionSettings) -> Result<(), PrefilterError> {
        let (size, depth) = (self.stack.size(), self.stack.feature(FeatureRole::Depth));
        let (lack, estimate) = match depth {
            Some(depth) => {
                check(depth, size)?;
                let mean = position_from_depth(&depth.estimate.mean);
                let noise = Noise::VarianceOfMean(measured_roughness(&mean, settings));
                (Lack::POSITION, Estimate { mean, noise })
            }
            None => (Lack::PLACE, Estimate { mean: position_on_screen(size), noise: Noise::Unknown }),
        };
        self.lacks_feature(lack);
        self.stack.to_mut().features.insert(0, Feature { role: FeatureRole::Position, estimate });
        Ok(())
    }

    /// Gives every feature of unknown noise the variance that its roughness tells.
    fn measure_features(&mut self, settings: &CompletionSettings) {
        if settings.feature_roughness > 0.0 && self.stack.features.iter().any(|f| f.estimate.noise == Noise::Unknown) {
            let features = self.stack.to_mut().features.iter_mut();
            for feature in features.filter(|feature| feature.estimate.noise == Noise::Unknown) {
                let variance = measured_roughness(&feature.estimate.mean, settings);
                feature.estimate.noise = Noise::VarianceOfMean(variance);
            }
        }
    }

    fn measure_noise(&mut self, settings: &CompletionSettings) -> Result<(), PrefilterError> {
        let lacking = |component: &Component| component.radiance.noise == Noise::Unknown;
        let unknown = self.stack.components.iter().filter(|component| lacking(component));
        let mut variances = Vec::new();
        for component in unknown {
            variances.push(measured_variance(&component.radiance.mean, &self.stack, settings)?);
        }
        if !variances.is_empty() {
            self.lacks.push(Lack::NOISE);
            let components = self.stack.to_mut().components.iter_mut().filter(|component| lacking(component));
            for (component, variance) in components.zip(variances) {
                component.radiance.noise = Noise::VarianceOfMean(variance);
            }
        } else if self.stack.components.iter().any(|c| matches!(c.radiance.noise, Noise::VarianceOfMean(_))) {
            self.lacks.push(Lack::HALVES);
        }
        Ok(())
    }
}

/// How many buckets it comes in, if it does.
fn buckets(estimate: &Estimate) -> Option<usize> {
    if let Noise::Buckets(buckets) = &estimate.noise { Some(buckets.len()) } else { None }
}

/// Whether most pixels have samples in no more than one of so many `buckets`.
fn are_lone(counts: &SampleCounts, buckets: usize) -> bool {
    let grouped = counts.grouped(buckets);
    // Two with samples are enough to know: those behind them are not counted.
    let is_lone = |pixel: &usize| (0..buckets).filter(|bucket| grouped.of(*pixel, *bucket) > 0).nth(1).is_none();
    2 * (0..counts.total.len()).into_par_iter().filter(is_lone).count() > counts.total.len()
}

/// Gives `image` the values of `other` where there are `marks`.
fn replace(image: &mut Image, other: &Image, marks: &[bool]) {
    for (plane, other) in image.channels_mut().iter_mut().zip(other.channels()) {
        for ((value, other), mark) in plane.iter_mut().zip(other).zip(marks) {
            if *mark {
                *value = *other;
            }
        }
    }
}

/// The variance of a feature, as its roughness tells it.
fn measured_roughness(mean: &Image, settings: &CompletionSettings) -> Image {
    let mut variance = roughness(mean);
    variance.channels_mut().iter_mut().flatten().for_each(|v| *v *= settings.feature_roughness);
    variance
}

#[cfg(test)]
mod tests;
