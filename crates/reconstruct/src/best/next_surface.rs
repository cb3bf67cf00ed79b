//! Where paths go on from the feature hit, as features: how near the next surface lies, and whether light reaches it. In
//! corners and under tables they tell what indirect light does, where nothing else changes.

use stack::{Cancelled, Feature, Image, Monitor, SampleCounts};

use super::crossed::Crossed;
use super::halves::mean_of;
use super::natural::{natural_scale, natural_variances};
use super::settings::{BestSettings, FitSettings};
use crate::per_pixel::plane;
use crate::prefilter::{FeatureSet, VarianceSource, normalised, normalised_halves};

/// Distance between fits, what a pixel needs of them lest it gets one of its own, and the radius of their windows: what
/// is only a feature may be rebuilt with a quarter of the fits.
const STRIDE: usize = 6;
const COVERED: f32 = 0.2;
const RADIUS: usize = 9;

/// Planes of `next` features, freed of noise by a regression on the `others`, each half with weights from the other:
/// paths scatter anywhere, so they are noisier than anything seen directly. `None` where one does not come in buckets.
/// Reports the stage `prefilter`.
///
/// # Errors
/// When `monitor` cancels.
pub fn rebuilt_next_surface(
    next: &[&Feature],
    others: &FeatureSet,
    counts: &SampleCounts,
    settings: &BestSettings,
    monitor: &dyn Monitor,
) -> Result<Option<Vec<Vec<f32>>>, Cancelled> {
    let Some(noisy) = next.iter().map(|feature| Noisy::of(feature, counts, settings)).collect::<Option<Vec<_>>>()
    else {
        return Ok(None);
    };
    let of_half = |half: usize| noisy.iter().flat_map(|noisy| noisy.halves[half].clone()).collect::<Vec<_>>();
    let halves = [of_half(0), of_half(1)];
    let variances: Vec<Vec<f32>> = noisy.into_iter().flat_map(|noisy| noisy.variances).collect();
    let (size, share) = (others.size, 1.0 / variances.len() as f32);
    let noise = plane(size.pixels(), |pixel| share * variances.iter().map(|plane| plane[pixel]).sum::<f32>());
    let halves = halves.each_ref().map(Vec::as_slice);
    let crossed =
        Crossed { size, features: &others.planes, halves, variances: &variances, noise: &noise, importance: None };
    let settings = FitSettings {
        stride: STRIDE,
        covered: COVERED,
        first_radius: RADIUS,
        first_bandwidth: settings.features.next_bandwidth,
        ..settings.regression
    };
    let fitted = crossed.fit(halves, &settings, "prefilter", monitor)?;
    let mut fitted = fitted.into_iter().map(|planes| Image::from_channels(size, planes));
    Ok(fitted.next().zip(fitted.next()).map(|(a, b)| mean_of(&[a, b]).into_channels()))
}

/// Both halves of a feature on its natural scale, and their variance.
struct Noisy {
    halves: [Vec<Vec<f32>>; 2],
    variances: Vec<Vec<f32>>,
}

impl Noisy {
    fn of(feature: &Feature, counts: &SampleCounts, settings: &BestSettings) -> Option<Self> {
        let scale = natural_scale(feature.role);
        let mut halves = normalised_halves(feature, counts)?;
        halves.iter_mut().flatten().flatten().for_each(|v| *v *= scale);
        let variance = normalised(feature, counts, VarianceSource::Buckets).variance?;
        Some(Self { halves, variances: natural_variances(&variance, scale, &settings.features)? })
    }
}

#[cfg(test)]
mod tests;
