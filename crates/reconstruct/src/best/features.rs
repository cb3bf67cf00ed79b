//! Features on natural scales, freed of noise by non-local means.

use std::borrow::Cow;
use std::ops::Range;

use rayon::prelude::*;
use stack::{Cancelled, Feature, FeatureRole, FeatureStack, Monitor, SampleCounts, Size};

use super::by_others::{Rebuilding, rebuilt_by_others};
use super::natural::{natural_scale, natural_variances};
use super::settings::{BestSettings, FeatureSettings};
use crate::bands::rows_of;
use crate::completion::has_depth;
use crate::nl_means::{Guide, nl_means, units};
use crate::patch_distance::{NoisyPlanes, PatchComparison};
use crate::prefilter::{FeatureSet, PrefilterError, VarianceSource, check, normalised, regressors};

/// Features that explain a picture, and those among them that tell surfaces apart.
#[derive(Clone, Debug, PartialEq)]
pub struct CleanFeatures {
    /// All of them. Albedo and visibility fill a range of 1, normals one of 2, positions one of 1 along the longest
    /// side of their box.
    pub set: FeatureSet,
    /// Numbers of the planes that tell surfaces apart: of all but visibility.
    pub separating: Vec<usize>,
    /// Whether those do not: there is no normal, and positions lie on a plane before the camera.
    pub flat: bool,
}

impl CleanFeatures {
    /// Some `rows` of all of them.
    pub(super) fn rows(&self, rows: &Range<usize>) -> Self {
        let FeatureSet { size, planes, groups } = &self.set;
        let planes = planes.iter().map(|plane| rows_of(plane, *size, rows)).collect();
        let set = FeatureSet { size: Size::new(size.width, rows.len()), planes, groups: groups.clone() };
        Self { set, separating: self.separating.clone(), flat: self.flat }
    }

    /// Adds the `planes` of some features as a group.
    fn add(&mut self, roles: &[FeatureRole], planes: Vec<Vec<f32>>) {
        let group = self.set.planes.len()..self.set.planes.len() + planes.len();
        if !roles.contains(&FeatureRole::Visibility) {
            self.separating.extend(group.clone());
        }
        self.set.groups.push(group);
        self.set.planes.extend(planes);
    }

    /// Adds a group of `noisy` features, rebuilt by those there are, or filtered by themselves where they do not come in buckets.
    fn add_noisy(
        &mut self,
        noisy: Vec<Cow<Feature>>,
        how: Rebuilding,
        counts: &SampleCounts,
        settings: &BestSettings,
        monitor: &dyn Monitor,
    ) -> Result<(), PrefilterError> {
        let by_others = match &noisy[..] {
            [] => return Ok(()),
            _ if self.set.planes.is_empty() => None,
            noisy => rebuilt_by_others(noisy, &self.set, counts, how, settings, monitor)?,
        };
        let planes = match by_others {
            Some(planes) => planes,
            None => {
                monitor.begin("prefilter", units(self.set.size) * noisy.len() as u64);
                let filtered = |feature: &Cow<Feature>| filtered(feature, counts, &settings.features, monitor);
                noisy.iter().map(filtered).collect::<Result<Vec<_>, _>>()?.concat()
            }
        };
        let roles: Vec<FeatureRole> = noisy.iter().map(|feature| feature.role).collect();
        self.add(&roles, planes);
        Ok(())
    }

    /// The planes that tell surfaces apart.
    pub fn separators(&self) -> impl Iterator<Item = &[f32]> {
        self.separating.iter().map(|plane| self.set.planes[*plane].as_slice())
    }
}

/// The features of `stack`, each group filtered by itself; visibility and what lies next by the others. Reports the stage
/// `prefilter`.
///
/// # Errors
/// When there is no feature, one has a wrong shape, or `monitor` cancels.
pub fn clean_features(
    stack: &FeatureStack,
    settings: &BestSettings,
    monitor: &dyn Monitor,
) -> Result<CleanFeatures, PrefilterError> {
    let regressors = Regressors::of(stack)?;
    regressors.filtered(stack.features.iter().map(Cow::Borrowed), &stack.samples, settings, monitor)
}

/// The same, but takes the features out of the `stack`: each is freed as soon as it is filtered.
///
/// # Errors
/// As there.
pub fn clean_features_freeing(
    stack: &mut FeatureStack,
    settings: &BestSettings,
    monitor: &dyn Monitor,
) -> Result<CleanFeatures, PrefilterError> {
    let regressors = Regressors::of(stack)?;
    let features = std::mem::take(&mut stack.features);
    regressors.filtered(features.into_iter().map(Cow::Owned), &stack.samples, settings, monitor)
}

/// Which features of a stack explain its radiance.
struct Regressors {
    size: Size,
    roles: Vec<FeatureRole>,
    /// See [`CleanFeatures`].
    flat: bool,
}

impl Regressors {
    fn of(stack: &FeatureStack) -> Result<Self, PrefilterError> {
        let next = stack.features.iter().filter(|feature| feature.role.is_of_next_surface());
        next.into_iter().try_for_each(|feature| check(feature, stack.size()))?;
        Ok(Self {
            size: stack.size(),
            roles: regressors(stack)?.into_iter().map(|feature| feature.role).collect(),
            flat: stack.feature(FeatureRole::Normal).is_none() && !has_depth(stack),
        })
    }

    fn filtered<'a>(
        self,
        features: impl Iterator<Item = Cow<'a, Feature>>,
        counts: &SampleCounts,
        settings: &BestSettings,
        monitor: &dyn Monitor,
    ) -> Result<CleanFeatures, PrefilterError> {
        let Self { size, roles, flat } = self;
        let FeatureSettings { next, next_bandwidth, visibility_bandwidth, .. } = settings.features;
        let is_noisy = |role| role == FeatureRole::Visibility && visibility_bandwidth > 0.0;
        let (mut plain, mut of_visibility, mut of_next) = (Vec::new(), Vec::new(), Vec::new());
        for feature in features {
            match feature.role {
                role if role.is_of_next_surface() => of_next.extend(next.then_some(feature)),
                role if roles.contains(&role) && is_noisy(role) => of_visibility.push(feature),
                role if roles.contains(&role) => plain.push(feature),
                _ => {}
            }
        }
        let set = FeatureSet { size, planes: Vec::new(), groups: Vec::new() };
        let mut all = CleanFeatures { set, separating: Vec::new(), flat };
        monitor.begin("prefilter", units(size) * plain.len() as u64);
        for feature in plain {
            all.add(&[feature.role], filtered(&feature, counts, &settings.features, monitor)?);
        }
        all.add_noisy(of_visibility, Rebuilding::visibility(visibility_bandwidth), counts, settings, monitor)?;
        all.add_noisy(of_next, Rebuilding::next_surface(next_bandwidth), counts, settings, monitor)?;
        Ok(all)
    }
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
        comparison: PatchComparison { patch_radius: settings.patch_radius, epsilon: 1e-8, noise_taken_off: 1.0 },
        radius: settings.radius,
    };
    nl_means(&guide, settings.bandwidth, &planes, monitor)
}

#[cfg(test)]
mod tests;
