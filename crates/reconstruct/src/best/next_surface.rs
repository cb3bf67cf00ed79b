//! Where paths go on from the feature hit, as features: how near the next surface lies, and whether light reaches it. In
//! corners and under tables they tell what indirect light does, where nothing else changes.

use stack::{Cancelled, Feature, Monitor, SampleCounts};

use super::features::{LEAST_VARIANCE, natural_scale};
use super::settings::BestSettings;
use crate::collaborative::{Fitted, Guides, Kernel, Ridge, collaborate, units};
use crate::patch_distance::Comparison;
use crate::prefilter::{FeatureSet, VarianceSource, normalised, normalised_halves};
use crate::variance::smoothed;

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
    let share = 1.0 / variances.len() as f32;
    let noise: Vec<f32> = (0..others.size.pixels())
        .map(|pixel| share * variances.iter().map(|plane| plane[pixel]).sum::<f32>())
        .collect();
    let responses = halves.each_ref().map(|half| half.iter().map(Vec::as_slice).collect::<Vec<_>>());
    let fit = &settings.regression;
    let fitted = Fitted {
        features: &others.planes,
        responses: &[&responses[0], &responses[1]],
        importance: None,
        noise: &noise,
        ridge: Ridge { least: fit.ridge, per_noise: fit.ridge_noise },
        stride: STRIDE,
        covered: COVERED,
    };
    let guides = Guides {
        size: others.size,
        values: &[&halves[1], &halves[0]],
        variances: &variances,
        comparison: Comparison { patch_radius: 2, epsilon: 1e-8, noise_taken_off: 1.0 },
        radius: RADIUS,
    };
    let kernel = Kernel { bandwidth: settings.features.next_bandwidth, sigma: f32::INFINITY };
    monitor.begin("prefilter", units(others.size, STRIDE, COVERED));
    let predicted = collaborate(&fitted, &guides, &[kernel], monitor)?;
    let mut halves = predicted.into_iter().flatten();
    Ok(halves.next().zip(halves.next()).map(|(mut mean, other)| {
        let values = mean.iter_mut().flatten().zip(other.iter().flatten());
        values.for_each(|(a, b)| *a = 0.5 * (*a + b));
        mean
    }))
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
        let mut variances = smoothed(&variance, settings.features.variance_radius)?.into_channels();
        variances.iter_mut().flatten().for_each(|v| *v = scale * scale * *v + LEAST_VARIANCE);
        Some(Self { halves, variances })
    }
}

#[cfg(test)]
mod tests;
