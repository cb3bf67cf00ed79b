//! The stages in a row: spikes, prefilter, regression, for each component of the picture.

use stack::{Cancelled, Component, ComponentRole, Fault, FeatureStack, Image, Monitor};

use crate::Settings;
use crate::box_filter::box_mean;
use crate::prefilter::{FeatureSet, PrefilterError, prefilter};
use crate::regression::{Regression, RegressionInput, regress};
use crate::spikes::{SpikeFree, remove_spikes};
use crate::variance::known_everywhere;

/// A reconstructed picture and what is known about it, one value per pixel and plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The picture: three channels of linear radiance.
    pub picture: Image,
    /// Estimated mean squared error of the picture, mean over RGB (eq. 7), summed over components.
    pub mse: Vec<f32>,
    /// What was taken out as spikes: noisy minus cleaned, three channels.
    pub spikes: Image,
    /// How many pixels were marked as spikes.
    pub marked: usize,
    /// Shared bandwidth h of the scattered light (eq. 14).
    pub bandwidth: Vec<f32>,
    /// Rank k of its reduced feature space (eq. 12).
    pub rank: Vec<f32>,
}

/// Why a stack could not be reconstructed.
#[derive(Debug, thiserror::Error)]
pub enum ReconstructError {
    /// The work was stopped by its monitor.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Nothing is known about the noise of the colour.
    #[error(
        "nothing is known about the noise of layer '{layer}': expected buckets, half-buffers or a variance; \
         render with at least two buckets, or give several renders with --buckets"
    )]
    NoiseUnknown {
        /// Layer of the component.
        layer: &'static str,
    },
    /// The features cannot be used.
    #[error(transparent)]
    Prefilter(#[from] PrefilterError),
}

impl ReconstructError {
    /// Whose fault this is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Cancelled(_) => Fault::Interrupted,
            Self::NoiseUnknown { .. } => Fault::Input,
            Self::Prefilter(error) => error.fault(),
        }
    }
}

/// Reconstructs the picture of `stack`: every component by itself, then their sum.
///
/// # Errors
/// When the noise of a component is unknown, there is no feature, or `monitor` cancels.
pub fn reconstruct(
    stack: &FeatureStack,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let features = prefilter(stack, &settings.prefilter, monitor)?;
    let mut sum = empty(stack);
    for component in &stack.components {
        let dark = component.radiance.mean.channels().iter().all(|plane| plane.iter().all(|v| *v == 0.0));
        if !dark {
            add_component(&mut sum, stack, component, &features, settings, monitor)?;
        }
    }
    Ok(sum)
}

fn empty(stack: &FeatureStack) -> Reconstruction {
    let (size, pixels) = (stack.size(), stack.size().pixels());
    Reconstruction {
        picture: Image::zeros(size, 3),
        mse: vec![0.0; pixels],
        spikes: Image::zeros(size, 3),
        marked: 0,
        bandwidth: vec![0.0; pixels],
        rank: vec![0.0; pixels],
    }
}

fn add_component(
    sum: &mut Reconstruction,
    stack: &FeatureStack,
    component: &Component,
    features: &FeatureSet,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<(), ReconstructError> {
    let variance = component
        .radiance
        .variance_of_mean(&stack.samples)
        .ok_or(ReconstructError::NoiseUnknown { layer: component.role.layer() })?;
    let variance = known_everywhere(variance, &component.radiance.mean);
    match component.role {
        ComponentRole::Scattered => {
            let cleaned = remove_spikes(&component.radiance.mean, &variance, &settings.spikes, monitor)?;
            let SpikeFree { colour, variance, spikes, marked } = cleaned;
            let input = RegressionInput { colour: &colour, variance: &variance, features, active: None };
            let regression = regress(&input, &settings.regression, monitor)?;
            sum.spikes = spikes;
            sum.marked = marked.iter().filter(|marked| **marked).count();
            add(sum, &regression);
            (sum.bandwidth, sum.rank) = (regression.bandwidth, regression.rank);
        }
        ComponentRole::Emission => {
            let colour = &component.radiance.mean;
            add(sum, &rebuild_emission(colour, &variance, features, settings, monitor)?);
        }
    }
    Ok(())
}

fn add(sum: &mut Reconstruction, regression: &Regression) {
    sum.picture.add(&regression.picture);
    for (total, mse) in sum.mse.iter_mut().zip(&regression.mse) {
        *total += mse;
    }
}

/// Rebuilds directly seen emission. A lamp is no spike, and where every bucket sees the same of it there is nothing to
/// rebuild. No feature tells what a lamp or background looks like, so the regression is believed only as far as it stays
/// within the noise: with variance v of the noisy value y and a fit x, the result is y + w (x − y), w = v / max(v, (x − y)²)
/// over 3×3 pixels.
fn rebuild_emission(
    colour: &Image,
    variance: &Image,
    features: &FeatureSet,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Regression, Cancelled> {
    let (size, pixels) = (colour.size(), colour.pixels());
    let noise: Vec<f32> = (0..pixels).map(|pixel| variance.mean_at(pixel)).collect();
    let noisy: Vec<bool> = noise.iter().map(|v| *v > 0.0).collect();
    let input = RegressionInput { colour, variance, features, active: Some(&noisy) };
    let mut fit = regress(&input, &settings.regression, monitor)?;
    let change = |pixel: usize| {
        let (x, y) = (fit.picture.rgb(pixel), colour.rgb(pixel));
        (0..3).map(|c| (x[c] - y[c]).powi(2)).sum::<f32>() / 3.0
    };
    let change = box_mean(&(0..pixels).map(change).collect::<Vec<_>>(), size, 1);
    let noise = box_mean(&noise, size, 1);
    for pixel in (0..pixels).filter(|pixel| noisy[*pixel]) {
        let weight = noise[pixel] / noise[pixel].max(change[pixel]);
        for (x, y) in fit.picture.channels_mut().iter_mut().zip(colour.channels()) {
            x[pixel] = y[pixel] + weight * (x[pixel] - y[pixel]);
        }
        fit.mse[pixel] = weight * fit.mse[pixel] + (1.0 - weight) * noise[pixel];
    }
    Ok(fit)
}
