//! Features freed of noise: each half with the weights of the other (section 5.1), and both together (section 5.4).

use stack::{Cancelled, Feature, FeatureRole, FeatureStack, Monitor, Size};

use super::comparison;
use crate::nl_means::{Guide, nl_means, units};
use crate::patch_distance::NoisyPlanes;
use crate::prefilter::{FeatureSet, PrefilterError, VarianceSource, check, normalised, normalised_halves};
use crate::rivals::measured_features::whichever;
use crate::variance::smoothed;

/// Radius of the patches (section 5.1).
const PATCH_RADIUS: usize = 3;
/// Radius of the window.
const RADIUS: usize = 5;
/// Bandwidth k.
const BANDWIDTH: f32 = 0.5;
/// Radius of the second pass's window (section 5.4).
const FINAL_RADIUS: usize = 2;
/// Added to every variance: differences below its root are averaged away even where there is no noise.
const LEAST_VARIANCE: f32 = 1e-6;
/// What a pixel's distance is measured in, where columns and rows are features: the radius of the window.
const PIXEL_UNIT: f32 = 1.0 / 9.0;

/// The features of both halves, filtered.
#[derive(Clone, Debug)]
pub(crate) struct FeatureHalves {
    /// A, then B.
    pub(crate) filtered: [FeatureSet; 2],
}

impl FeatureHalves {
    fn add(&mut self, halves: [Vec<Vec<f32>>; 2]) {
        for (set, planes) in self.filtered.iter_mut().zip(halves) {
            set.groups.push(set.planes.len()..set.planes.len() + planes.len());
            set.planes.extend(planes);
        }
    }
}

/// Albedo, normal, visibility; depth, column and row, or position where there is no depth. Reports the stage
/// `prefilter`.
///
/// # Errors
/// When there is none, one does not fit its role or the stack, or `monitor` cancels.
pub(crate) fn half_features(stack: &FeatureStack, monitor: &dyn Monitor) -> Result<FeatureHalves, PrefilterError> {
    let size = stack.size();
    let place = whichever(stack, FeatureRole::Depth, FeatureRole::Position);
    let roles = [FeatureRole::Albedo, FeatureRole::Normal, FeatureRole::Visibility, place];
    let features: Vec<&Feature> = roles.iter().filter_map(|role| stack.feature(*role)).collect();
    if features.is_empty() {
        return Err(PrefilterError::NoFeatures);
    }
    monitor.begin("prefilter", 2 * units(size) * features.len() as u64);
    let set = FeatureSet { size, planes: Vec::new(), groups: Vec::new() };
    let mut halves = FeatureHalves { filtered: [set.clone(), set] };
    for feature in features {
        check(feature, size)?;
        halves.add(cross_filtered(stack, feature, monitor)?);
    }
    if place != FeatureRole::Position || stack.feature(place).is_none() {
        let place = |along: &dyn Fn(usize) -> usize| -> Vec<f32> {
            (0..size.pixels()).map(|i| along(i) as f32 * PIXEL_UNIT).collect()
        };
        let planes = vec![place(&|i| i % size.width), place(&|i| i / size.width)];
        halves.add([planes.clone(), planes]);
    }
    Ok(halves)
}

/// Both halves of `feature`, each averaged with the weights of the other; its mean twice where there are no halves.
fn cross_filtered(
    stack: &FeatureStack,
    feature: &Feature,
    monitor: &dyn Monitor,
) -> Result<[Vec<Vec<f32>>; 2], Cancelled> {
    let whole = normalised(feature, &stack.samples, VarianceSource::Buckets);
    let variance = whole.variance.and_then(|variance| smoothed(&variance, 1));
    let (Some(halves), Some(variance)) = (normalised_halves(feature, &stack.samples), variance) else {
        monitor.advance(2 * units(stack.size()));
        return Ok([whole.planes.clone(), whole.planes]);
    };
    let of_half = |plane: Vec<f32>| plane.into_iter().map(|v| 2.0 * v + LEAST_VARIANCE).collect();
    let variances: Vec<Vec<f32>> = variance.into_channels().into_iter().map(of_half).collect();
    let filter = |half: usize| filtered(&halves[half], &halves[1 - half], &variances, RADIUS, stack.size(), monitor);
    Ok([filter(0)?, filter(1)?])
}

/// `planes` averaged with weights from `guide` and its `variances`.
fn filtered(
    planes: &[Vec<f32>],
    guide: &[Vec<f32>],
    variances: &[Vec<f32>],
    radius: usize,
    size: Size,
    monitor: &dyn Monitor,
) -> Result<Vec<Vec<f32>>, Cancelled> {
    let guide = NoisyPlanes { size, values: guide, variances };
    nl_means(&Guide { planes: guide, comparison: comparison(PATCH_RADIUS), radius }, BANDWIDTH, planes, monitor)
}

/// Section 5.4: the mean of both filtered halves, filtered once more with the noise that their difference shows.
///
/// # Errors
/// When `monitor` cancels.
pub(crate) fn final_features(halves: &FeatureHalves, monitor: &dyn Monitor) -> Result<FeatureSet, Cancelled> {
    let [a, b] = &halves.filtered;
    let merge = |value: &dyn Fn(f32, f32) -> f32| -> Vec<Vec<f32>> {
        let planes = a.planes.iter().zip(&b.planes);
        planes.map(|(a, b)| a.iter().zip(b).map(|(a, b)| value(*a, *b)).collect()).collect()
    };
    let mut planes = merge(&|a, b| 0.5 * (a + b));
    let variances = merge(&|a, b| 0.25 * (a - b) * (a - b) + LEAST_VARIANCE);
    monitor.begin("second prefilter", units(a.size) * a.groups.len() as u64);
    for group in &a.groups {
        let mean = &planes[group.clone()];
        let found = filtered(mean, mean, &variances[group.clone()], FINAL_RADIUS, a.size, monitor)?;
        planes.splice(group.clone(), found);
    }
    Ok(FeatureSet { size: a.size, planes, groups: a.groups.clone() })
}
