//! A noisy picture and what it should have been.

use stack::{ComponentRole, FeatureStack, Image, Monitor};

use crate::components::variance_of;
use crate::emission::with_emission_apart;
use crate::prefilter::PrefilterSettings;
use crate::reconstruction::ReconstructError;
use crate::rivals::lbf::primary::Primary;
use crate::rivals::lbf::secondary::{Inputs, secondary};

/// One picture of the training set.
#[derive(Clone, Debug)]
pub struct Example {
    pub(super) primary: Primary,
    pub(super) inputs: Vec<Inputs>,
    /// RGB of the reference.
    pub(super) reference: [Vec<f32>; 3],
}

impl Example {
    /// The scattered light of `stack`, with a `reference` of the same light.
    ///
    /// # Errors
    /// When the stack has no scattered light or cannot be filtered, and when `monitor` cancels.
    ///
    /// # Panics
    /// When the reference has another size or number of channels: that is a mistake in the calling code.
    pub fn new(
        stack: &FeatureStack,
        reference: &Image,
        settings: &PrefilterSettings,
        monitor: &dyn Monitor,
    ) -> Result<Self, ReconstructError> {
        assert_eq!((reference.size(), reference.channels().len()), (stack.size(), 3));
        let components = with_emission_apart(stack, monitor);
        let scattered = components.iter().find(|component| component.role == ComponentRole::Scattered);
        let layer = ComponentRole::Scattered.layer();
        let scattered = scattered.ok_or(ReconstructError::NoiseUnknown { layer })?;
        let variance = variance_of(scattered, &stack.samples)?;
        let primary = Primary::new(stack, &scattered.radiance.mean, &variance, settings, monitor)?;
        let inputs = secondary(&primary);
        let reference = [0, 1, 2].map(|c| reference.channels()[c].clone());
        Ok(Self { primary, inputs, reference })
    }
}
