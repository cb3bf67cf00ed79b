//! The features of a stack as the rivals take them: normalised, with their noise, not filtered.

use stack::{Feature, FeatureRole, FeatureStack};

use crate::prefilter::{FeatureSet, PrefilterError, VarianceSource, check, normalised};
use crate::variance::known_everywhere;

/// Features in [−1, 1] as they were measured, and what is known about their noise.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeasuredFeatures {
    /// The means.
    pub(crate) set: FeatureSet,
    /// Variance of each plane's mean; zeros where nothing is known.
    pub(crate) variances: Vec<Vec<f32>>,
}

/// Measures the features of `stack` that have one of `roles`, in that order.
///
/// # Errors
/// When there is none, or one does not fit its role or the stack.
pub(crate) fn measured(stack: &FeatureStack, roles: &[FeatureRole]) -> Result<MeasuredFeatures, PrefilterError> {
    let features: Vec<&Feature> = roles.iter().filter_map(|role| stack.feature(*role)).collect();
    if features.is_empty() {
        return Err(PrefilterError::NoFeatures);
    }
    let set = FeatureSet { size: stack.size(), planes: Vec::new(), groups: Vec::new() };
    let mut measured = MeasuredFeatures { set, variances: Vec::new() };
    for feature in features {
        check(feature, stack.size())?;
        measured.add(stack, feature);
    }
    Ok(measured)
}

/// The role that says where things are: `first` if the stack has it, else `second`.
pub(crate) fn whichever(stack: &FeatureStack, first: FeatureRole, second: FeatureRole) -> FeatureRole {
    if stack.feature(first).is_some() { first } else { second }
}

impl MeasuredFeatures {
    fn add(&mut self, stack: &FeatureStack, feature: &Feature) {
        let found = normalised(feature, &stack.samples, VarianceSource::Buckets);
        let start = self.set.planes.len();
        self.set.groups.push(start..start + found.planes.len());
        match found.variance {
            Some(variance) => {
                let mean = stack::Image::from_channels(stack.size(), found.planes.clone());
                self.variances.extend(known_everywhere(variance, &mean).into_channels());
            }
            None => self.variances.extend(vec![vec![0.0; stack.size().pixels()]; found.planes.len()]),
        }
        self.set.planes.extend(found.planes);
    }

    /// Adds the plane whose value at column x, row y is `value(x, y)`: a group of its own, free of noise.
    pub(crate) fn add_exact(&mut self, value: impl Fn(usize, usize) -> f32) {
        let size = self.set.size;
        let plane = (0..size.pixels()).map(|i| value(i % size.width, i / size.width)).collect();
        self.set.groups.push(self.set.planes.len()..self.set.planes.len() + 1);
        self.set.planes.push(plane);
        self.variances.push(vec![0.0; size.pixels()]);
    }
}
