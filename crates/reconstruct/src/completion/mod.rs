//! What a stack lacks, made up from what it has, so that every method can rebuild any stack.
//!
//! Most renderers' files say nothing about noise, and many hold no position. Steps, one file each: where nothing is known
//! about the noise of colour it is measured on the picture (`noise`), by what a local fit (`local_fit`) leaves of each
//! pixel; positions come from depth or, without it, from the screen (`place`). [`crate::recorruption`] makes half-buffers
//! of a mean and its variance.

mod lack;
mod local_fit;
mod noise;
mod place;

use std::borrow::Cow;

use stack::{Component, Estimate, Feature, FeatureRole, FeatureStack, Monitor, Noise};

use crate::prefilter::PrefilterError;
pub use lack::Lack;
use noise::measured_variance;
use place::{position_from_depth, position_on_screen};

stack::knobs! {
    /// How noise is measured on a picture of which nothing else is known.
    pub struct CompletionSettings("completion") {
        /// Radius of the windows in which noise is what a local fit does not explain, in pixels.
        noise_radius: usize = 2, 1..=8;
        /// Pixels whose features differ by more than this are left out of such a fit.
        noise_likeness: f32 = 0.1, 0.001..=100.0;
        /// Ridge of such a fit.
        noise_ridge: f32 = 1e-3, 1e-9..=10.0;
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

/// Completes `stack`: it comes back as it is where it lacks nothing.
///
/// # Errors
/// When a feature does not fit its role or the stack.
pub fn complete<'a>(
    stack: &'a FeatureStack,
    settings: &CompletionSettings,
    monitor: &dyn Monitor,
) -> Result<Completed<'a>, PrefilterError> {
    let mut completed = Completed { stack: Cow::Borrowed(stack), lacks: Vec::new() };
    if stack.feature(FeatureRole::Position).is_none() {
        completed.add_position();
    }
    completed.measure_noise(settings)?;
    completed.lacks.iter().for_each(|lack| monitor.note(&lack.to_string()));
    Ok(completed)
}

impl Completed<'_> {
    fn add_position(&mut self) {
        let (size, depth) = (self.stack.size(), self.stack.feature(FeatureRole::Depth));
        let (lack, mean) = match depth {
            Some(depth) => (Lack::POSITION, position_from_depth(&depth.estimate.mean)),
            None => (Lack::PLACE, position_on_screen(size)),
        };
        if self.stack.features.is_empty() {
            self.lacks.push(Lack::FEATURES);
        } else {
            self.lacks.push(lack);
        }
        let position = Feature { role: FeatureRole::Position, estimate: Estimate { mean, noise: Noise::Unknown } };
        self.stack.to_mut().features.insert(0, position);
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

#[cfg(test)]
mod tests;
