//! What a stack's samples say about pictures that were made from them.

use stack::{Component, ComponentRole, FeatureStack, Image, Monitor};

use crate::best::halves::{mean_of, sum_of};
use crate::best::split::split;
use crate::best::{BestSettings, GuideFeatures, guide_features, spread};
use crate::components::{is_lit, variance_of};
use crate::reconstruction::ReconstructError;

/// The noisy picture, made fit to judge others.
pub struct Evidence {
    /// All components, without fireflies: the low layer of scattered light, and its events spread.
    pub noisy: Image,
    /// Variance of its mean, without that of events.
    pub variance: Image,
    /// Events where they fell.
    pub events: Image,
    /// What tells surfaces apart.
    pub features: GuideFeatures,
}

impl Evidence {
    /// Gathers it from a complete `stack`; `picture` tells which pixels resemble each other.
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
        let mut of_surfaces = *settings;
        of_surfaces.features.next = false;
        let features = guide_features(stack, &of_surfaces, monitor)?;
        let [noisy, variance, events] = [(); 3].map(|()| Image::zeros(stack.size(), 3));
        let mut evidence = Self { noisy, variance, events, features };
        for component in stack.components.iter().filter(|component| is_lit(component)) {
            if component.role == ComponentRole::Scattered {
                evidence.add_scattered(stack, component, picture, settings, monitor)?;
            } else {
                evidence.noisy.add(&component.radiance.mean);
                evidence.variance.add(&variance_of(component, &stack.samples)?);
            }
        }
        Ok(evidence)
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
        self.noisy.add(&mean_of(&layers.low.halves));
        self.noisy.add(&spread::steadied(spread.halves, picture, &self.features, &settings.spread, monitor)?);
        self.events.add(&sum_of(&layers.events.light));
        // The layers know the variance of a half.
        let mut variance = layers.low.variance;
        variance.channels_mut().iter_mut().flatten().for_each(|v| *v *= 0.5);
        self.variance.add(&variance);
        Ok(())
    }
}
