//! A picture rebuilt from its stack: every component by the method that was asked for, then their sum.

use stack::{Cancelled, Component, ComponentRole, Fault, FeatureStack, Image, Monitor, Size};

use crate::emission::{rebuild_emission, with_emission_apart};
use crate::method::{Fit, Method};
use crate::prefilter::{FeatureSet, PrefilterError, prefilter};
use crate::rivals::Rival;
use crate::rivals::wlr::Variant;
use crate::variance::known_everywhere;
use crate::{Settings, best, paper, rivals};

/// A reconstructed picture and what is known about it, one value per pixel and plane. What a method does not have is
/// `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The picture: three channels of linear radiance.
    pub picture: Image,
    /// Estimated mean squared error of the picture, mean over RGB, summed over components.
    pub mse: Vec<f32>,
    /// What was taken for spikes: noisy minus cleaned, three channels.
    pub spikes: Option<Image>,
    /// How many pixels were marked as spikes.
    pub marked: usize,
    /// Shared bandwidth h of the scattered light (eq. 14).
    pub bandwidth: Option<Vec<f32>>,
    /// Rank k of its reduced feature space (eq. 12).
    pub rank: Option<Vec<f32>>,
}

impl Reconstruction {
    /// `picture`, of which nothing more is known and no error.
    pub fn plain(picture: Image) -> Self {
        let mse = vec![0.0; picture.pixels()];
        Self { picture, mse, spikes: None, marked: 0, bandwidth: None, rank: None }
    }

    /// Adds a component; what there is of maps comes from whichever component has it.
    fn add(&mut self, other: Self) {
        self.picture.add(&other.picture);
        for (total, mse) in self.mse.iter_mut().zip(&other.mse) {
            *total += mse;
        }
        self.marked += other.marked;
        self.spikes = self.spikes.take().or(other.spikes);
        self.bandwidth = self.bandwidth.take().or(other.bandwidth);
        self.rank = self.rank.take().or(other.rank);
    }
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
    /// The method needs independent parts of the picture.
    #[error(
        "the noise of layer '{layer}' does not come in buckets or half-buffers, which this method needs: choose \
         --preset paper, or give several renders with --buckets"
    )]
    NoBuckets {
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
            Self::NoiseUnknown { .. } | Self::NoBuckets { .. } => Fault::Input,
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
    match settings.method.method {
        Method::Ld => sum_of_components(stack.size(), &stack.components, |component| unfiltered(stack, component)),
        Method::Ours => ours(stack, settings, monitor),
        Method::Wlr => rivals::reconstruct(stack, Rival::Wlr(Variant::Plain), settings, monitor),
        Method::Wlrp => rivals::reconstruct(stack, Rival::Wlr(Variant::Pilot), settings, monitor),
        Method::Wlrv => rivals::reconstruct(stack, Rival::Wlr(Variant::Visibility), settings, monitor),
        Method::Nfor => rivals::reconstruct(stack, Rival::Nfor, settings, monitor),
        Method::Apr => rivals::reconstruct(stack, Rival::Apr, settings, monitor),
    }
}

fn ours(stack: &FeatureStack, settings: &Settings, monitor: &dyn Monitor) -> Result<Reconstruction, ReconstructError> {
    match settings.method.fit {
        Fit::Local => {
            let features = prefilter(stack, &settings.prefilter, monitor)?;
            sum_of_components(stack.size(), &with_emission_apart(stack, monitor), |component| {
                rebuilt(stack, component, &features, settings, monitor)
            })
        }
        Fit::Collaborative => {
            let features = best::guide_features(stack, &settings.best.features, monitor)?;
            sum_of_components(stack.size(), &stack.components, |component| match component.role {
                ComponentRole::Scattered => best::rebuild(stack, component, &features, &settings.best, monitor),
                ComponentRole::Emission => {
                    let (radiance, variance) = (&component.radiance.mean, variance_of(stack, component)?);
                    let mut rebuilt = rebuild_emission(radiance, &variance, &features.set, settings, monitor)?;
                    best::share_unseen(&mut rebuilt.mse, &variance);
                    Ok(rebuilt)
                }
            })
        }
    }
}

/// What `rebuild` makes of every component that is not black, added up.
pub(crate) fn sum_of_components(
    size: Size,
    components: &[Component],
    rebuild: impl Fn(&Component) -> Result<Reconstruction, ReconstructError>,
) -> Result<Reconstruction, ReconstructError> {
    let mut sum = Reconstruction::plain(Image::zeros(size, 3));
    for component in components.iter().filter(|component| is_lit(component)) {
        sum.add(rebuild(component)?);
    }
    Ok(sum)
}

fn is_lit(component: &Component) -> bool {
    component.radiance.mean.channels().iter().any(|plane| plane.iter().any(|v| *v != 0.0))
}

/// Variance of the mean of `component`, known everywhere.
pub(crate) fn variance_of(stack: &FeatureStack, component: &Component) -> Result<Image, ReconstructError> {
    let variance = component
        .radiance
        .variance_of_mean(&stack.samples)
        .ok_or(ReconstructError::NoiseUnknown { layer: component.role.layer() })?;
    Ok(known_everywhere(variance, &component.radiance.mean))
}

/// The mean of the samples, with its variance as error.
fn unfiltered(stack: &FeatureStack, component: &Component) -> Result<Reconstruction, ReconstructError> {
    let variance = variance_of(stack, component)?;
    let mse = (0..variance.pixels()).map(|pixel| variance.mean_at(pixel)).collect();
    Ok(Reconstruction { mse, ..Reconstruction::plain(component.radiance.mean.clone()) })
}

fn rebuilt(
    stack: &FeatureStack,
    component: &Component,
    features: &FeatureSet,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let (radiance, variance) = (&component.radiance.mean, variance_of(stack, component)?);
    Ok(match component.role {
        ComponentRole::Scattered => paper::rebuild(radiance, &variance, features, settings, monitor)?,
        ComponentRole::Emission => rebuild_emission(radiance, &variance, features, settings, monitor)?,
    })
}
