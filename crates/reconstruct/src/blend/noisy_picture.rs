//! What a stack's samples say about pictures that were made from them.

use stack::{Component, ComponentRole, FeatureStack, Image, Monitor};

use crate::best::halves::{mean_of, sum_of};
use crate::best::split::split;
use crate::best::{BestSettings, CleanFeatures, clean_features, spread};
use crate::components::{is_lit, variance_of};
use crate::reconstruction::ReconstructError;

/// The noisy picture of a stack, made fit to judge others.
pub struct NoisyPicture {
    /// All components, without fireflies: the low layer of scattered light, and its events spread.
    pub picture: Image,
    /// Variance of its mean, without that of events.
    pub variance: Image,
    /// Events where they fell.
    pub events: Image,
    /// What tells surfaces apart.
    pub features: CleanFeatures,
}

impl NoisyPicture {
    /// That of a complete `stack`; `picture` tells which pixels resemble each other.
    ///
    /// # Errors
    /// When a feature cannot be used, nothing is known about noise, or `monitor` cancels.
    pub fn new(
        stack: &FeatureStack,
        picture: &Image,
        settings: &BestSettings,
        monitor: &dyn Monitor,
    ) -> Result<Self, ReconstructError> {
        // The network was trained without what lies next.
        let mut without_next = *settings;
        without_next.features.next = false;
        let features = clean_features(stack, &without_next, monitor)?;
        let [mean, variance, events] = [(); 3].map(|()| Image::zeros(stack.size(), 3));
        let mut noisy = Self { picture: mean, variance, events, features };
        for component in stack.components.iter().filter(|component| is_lit(component)) {
            if component.role == ComponentRole::Scattered {
                noisy.add_scattered(stack, component, picture, settings, monitor)?;
            } else {
                noisy.picture.add(&component.radiance.mean);
                noisy.variance.add(&variance_of(component, &stack.samples)?);
            }
        }
        Ok(noisy)
    }

    fn add_scattered(
        &mut self,
        stack: &FeatureStack,
        component: &Component,
        picture: &Image,
        settings: &BestSettings,
        monitor: &dyn Monitor,
    ) -> Result<(), ReconstructError> {
        let layers = split(component, &stack.samples, &settings.split)?;
        let spread = spread::spread(&layers.events, picture, &self.features, &settings.spread);
        self.picture.add(&mean_of(&layers.low.halves));
        self.picture.add(&spread::steadied(spread.halves, picture, &self.features, &settings.spread, monitor)?);
        self.events.add(&sum_of(&layers.events.light));
        // The layers know the variance of a half.
        let mut variance = layers.low.variance;
        variance.channels_mut().iter_mut().flatten().for_each(|v| *v *= 0.5);
        self.variance.add(&variance);
        Ok(())
    }
}
