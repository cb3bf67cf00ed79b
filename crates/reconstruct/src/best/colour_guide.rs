//! The picture's own brightness where no feature tells surfaces apart.

use std::borrow::Cow;

use stack::{FeatureRole, FeatureStack, Image};

use super::features::GuideFeatures;
use crate::completion::has_depth;

/// `features`, and where none of them tells surfaces apart (there is no normal, and positions lie on a plane before the
/// camera) the logarithm of `picture`, `weight` times, as another: kernels then stay on pixels of like colour.
pub fn with_colour<'a>(
    features: &'a GuideFeatures,
    stack: &FeatureStack,
    picture: &Image,
    weight: f32,
) -> Cow<'a, GuideFeatures> {
    if weight == 0.0 || stack.feature(FeatureRole::Normal).is_some() || has_depth(stack) {
        return Cow::Borrowed(features);
    }
    let mut guided = features.clone();
    let first = guided.set.planes.len();
    let logarithm = |v: &f32| weight * (v + 0.02).max(0.01).ln();
    guided.set.planes.extend(picture.channels().iter().map(|plane| plane.iter().map(logarithm).collect()));
    guided.set.groups.push(first..first + 3);
    guided.surfaces.extend(first..first + 3);
    Cow::Owned(guided)
}
