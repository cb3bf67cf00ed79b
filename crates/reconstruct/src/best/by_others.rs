//! Features that are much noisier than others, freed of noise by a regression on those. Visibility is the mean of few shadow
//! rays: in soft shadows and under a sky its noise would be seen on every surface, as mottles that both halves share. And so
//! are those that tell where paths go on from the feature hit: how near the next surface lies, and whether light reaches it.
//! In corners and under tables they say what indirect light does, where nothing else changes.

use std::borrow::Cow;

use stack::{Cancelled, Feature, Image, Monitor, SampleCounts};

use super::crossed::Crossed;
use super::halves::mean_of;
use super::natural::{natural_scale, natural_variances};
use super::settings::{BestSettings, FitSettings};
use crate::per_pixel::plane;
use crate::prefilter::{FeatureSet, VarianceSource, normalised, normalised_halves};

/// Radius of the windows.
const RADIUS: usize = 9;

/// How features are rebuilt.
#[derive(Clone, Copy, Debug)]
pub struct Rebuilding {
    /// Bandwidth k of the weights.
    bandwidth: f32,
    /// Distance between fits, and what a pixel needs of them lest it gets one of its own: what is only a feature may be
    /// rebuilt with a part of the fits.
    stride: usize,
    covered: f32,
}

impl Rebuilding {
    /// For what paths meet next.
    pub fn next_surface(bandwidth: f32) -> Self {
        Self { bandwidth, stride: 6, covered: 0.2 }
    }

    /// For visibility, which has borders of shadows that no other feature tells.
    pub fn visibility(bandwidth: f32) -> Self {
        Self { bandwidth, stride: 4, covered: 0.5 }
    }
}

/// Planes of `noisy` features, rebuilt by a regression on the `others`, each half with weights from the other. `None` where one
/// does not come in buckets. Reports the stage `prefilter`.
///
/// # Errors
/// When `monitor` cancels.
pub fn rebuilt_by_others(
    noisy: &[Cow<Feature>],
    others: &FeatureSet,
    counts: &SampleCounts,
    how: Rebuilding,
    settings: &BestSettings,
    monitor: &dyn Monitor,
) -> Result<Option<Vec<Vec<f32>>>, Cancelled> {
    let (mut halves, mut variances) = ([Vec::new(), Vec::new()], Vec::new());
    for feature in noisy {
        let Some(noisy) = Noisy::of(feature, counts, settings) else { return Ok(None) };
        halves.iter_mut().zip(noisy.halves).for_each(|(all, planes)| all.extend(planes));
        variances.extend(noisy.variances);
    }
    let (size, share) = (others.size, 1.0 / variances.len() as f32);
    let noise = plane(size.pixels(), |pixel| share * variances.iter().map(|plane| plane[pixel]).sum::<f32>());
    let halves = halves.each_ref().map(Vec::as_slice);
    let crossed =
        Crossed { size, features: &others.planes, halves, variances: &variances, noise: &noise, importance: None };
    let settings = FitSettings {
        stride: how.stride,
        covered: how.covered,
        first_radius: RADIUS,
        first_bandwidth: how.bandwidth,
        ..settings.regression
    };
    let fitted = crossed.fit(halves, &settings, "prefilter", monitor)?;
    let mut fitted = fitted.into_iter().map(|planes| Image::from_channels(size, planes));
    Ok(fitted.next().zip(fitted.next()).map(|(a, b)| mean_of(&[a, b]).into_channels()))
}

/// Both halves of a feature on its natural scale, and the variance of a half: twice that of their mean.
struct Noisy {
    halves: [Vec<Vec<f32>>; 2],
    variances: Vec<Vec<f32>>,
}

impl Noisy {
    fn of(feature: &Feature, counts: &SampleCounts, settings: &BestSettings) -> Option<Self> {
        let scale = natural_scale(feature.role);
        let mut halves = normalised_halves(feature, counts)?;
        halves.iter_mut().flatten().flatten().for_each(|v| *v *= scale);
        let mut variance = normalised(feature, counts, VarianceSource::Buckets).variance?;
        variance.channels_mut().iter_mut().flatten().for_each(|v| *v *= 2.0);
        Some(Self { halves, variances: natural_variances(&variance, scale, &settings.features)? })
    }
}

#[cfg(test)]
mod tests;
