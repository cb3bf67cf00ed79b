//! Features on natural scales, freed of noise by non-local means.

use std::ops::Range;

use rayon::prelude::*;
use stack::{Cancelled, Feature, FeatureRole, FeatureStack, Monitor, SampleCounts, Size};

use super::by_others::{Rebuilding, rebuilt_by_others};
use super::natural::{natural_scale, natural_variances};
use super::settings::{BestSettings, FeatureSettings};
use crate::bands::rows_of;
use crate::collaborative::Guide;
use crate::completion::has_depth;
use crate::nl_means::{nl_means, units};
use crate::patch_distance::{Comparison, NoisyPlanes};
use crate::prefilter::{FeatureSet, PrefilterError, VarianceSource, check, guides, normalised};

/// Features that explain a picture, and those among them that tell surfaces apart.
#[derive(Clone, Debug, PartialEq)]
pub struct GuideFeatures {
    /// All of them. Albedo and visibility fill a range of 1, normals one of 2, positions one of 1 along the longest
    /// side of their box.
    pub set: FeatureSet,
    /// Planes that tell surfaces apart: all but visibility.
    pub surfaces: Vec<usize>,
    /// Whether those do not: there is no normal, and positions lie on a plane before the camera.
    pub flat: bool,
}

impl GuideFeatures {
    /// Some `rows` of all of them.
    pub(super) fn rows(&self, rows: &Range<usize>) -> Self {
        let FeatureSet { size, planes, groups } = &self.set;
        let planes = planes.iter().map(|plane| rows_of(plane, *size, rows)).collect();
        let set = FeatureSet { size: Size::new(size.width, rows.len()), planes, groups: groups.clone() };
        Self { set, surfaces: self.surfaces.clone(), flat: self.flat }
    }

    /// Adds the `planes` of some features as a group.
    fn add(&mut self, features: &[&Feature], planes: Vec<Vec<f32>>) {
        let group = self.set.planes.len()..self.set.planes.len() + planes.len();
        if features.iter().all(|feature| feature.role != FeatureRole::Visibility) {
            self.surfaces.extend(group.clone());
        }
        self.set.groups.push(group);
        self.set.planes.extend(planes);
    }

    /// Adds a group of `noisy` features, rebuilt by those there are, or filtered by themselves where they do not come in buckets.
    fn add_noisy(
        &mut self,
        noisy: &[&Feature],
        how: Rebuilding,
        stack: &FeatureStack,
        settings: &BestSettings,
        monitor: &dyn Monitor,
    ) -> Result<(), PrefilterError> {
        let by_others = match noisy {
            [] => return Ok(()),
            _ if self.set.planes.is_empty() => None,
            _ => rebuilt_by_others(noisy, &self.set, &stack.samples, how, settings, monitor)?,
        };
        let planes = match by_others {
            Some(planes) => planes,
            None => {
                monitor.begin("prefilter", units(stack.size()) * noisy.len() as u64);
                let filtered = |feature: &&Feature| filtered(feature, &stack.samples, &settings.features, monitor);
                noisy.iter().map(filtered).collect::<Result<Vec<_>, _>>()?.concat()
            }
        };
        self.add(noisy, planes);
        Ok(())
    }

    /// The planes that tell surfaces apart.
    pub fn surfaces(&self) -> impl Iterator<Item = &[f32]> {
        self.surfaces.iter().map(|plane| self.set.planes[*plane].as_slice())
    }
}

/// The features of `stack`, each group filtered by itself; visibility and what lies next by the others. Reports the stage
/// `prefilter`.
///
/// # Errors
/// When there is no feature, one has a wrong shape, or `monitor` cancels.
pub fn guide_features(
    stack: &FeatureStack,
    settings: &BestSettings,
    monitor: &dyn Monitor,
) -> Result<GuideFeatures, PrefilterError> {
    let FeatureSettings { next, next_bandwidth, visibility_bandwidth, .. } = settings.features;
    let is_noisy = |feature: &&Feature| feature.role == FeatureRole::Visibility && visibility_bandwidth > 0.0;
    let (visibility, plain): (Vec<&Feature>, Vec<&Feature>) = guides(stack)?.into_iter().partition(is_noisy);
    let set = FeatureSet { size: stack.size(), planes: Vec::new(), groups: Vec::new() };
    let flat = stack.feature(FeatureRole::Normal).is_none() && !has_depth(stack);
    let mut all = GuideFeatures { set, surfaces: Vec::new(), flat };
    monitor.begin("prefilter", units(stack.size()) * plain.len() as u64);
    for feature in plain {
        all.add(&[feature], filtered(feature, &stack.samples, &settings.features, monitor)?);
    }
    all.add_noisy(&visibility, Rebuilding::visibility(visibility_bandwidth), stack, settings, monitor)?;
    if next {
        let next: Vec<&Feature> = stack.features.iter().filter(|feature| feature.role.is_of_next_surface()).collect();
        for feature in &next {
            check(feature, stack.size())?;
        }
        all.add_noisy(&next, Rebuilding::next_surface(next_bandwidth), stack, settings, monitor)?;
    }
    Ok(all)
}

fn filtered(
    feature: &Feature,
    counts: &SampleCounts,
    settings: &FeatureSettings,
    monitor: &dyn Monitor,
) -> Result<Vec<Vec<f32>>, Cancelled> {
    let scale = natural_scale(feature.role);
    let normal = normalised(feature, counts, VarianceSource::Buckets);
    let mut planes = normal.planes;
    planes.par_iter_mut().flatten().for_each(|v| *v *= scale);
    let variances = normal.variance.and_then(|variance| natural_variances(&variance, scale, settings));
    let Some(variances) = variances else {
        monitor.advance(units(feature.estimate.mean.size()));
        return Ok(planes);
    };
    let guide = Guide {
        planes: NoisyPlanes { size: feature.estimate.mean.size(), values: &planes, variances: &variances },
        comparison: Comparison { patch_radius: settings.patch_radius, epsilon: 1e-8, noise_taken_off: 1.0 },
        radius: settings.radius,
    };
    nl_means(&guide, settings.bandwidth, &planes, monitor)
}

#[cfg(test)]
mod tests;
