//! The picture's own brightness where no feature tells surfaces apart.

use stack::Image;

use super::features::GuideFeatures;

/// `features`, where none of them tells surfaces apart, and the logarithm of `picture`, `weight` times, as another:
/// kernels then stay on pixels of like colour.
pub fn with_colour(features: &GuideFeatures, picture: &Image, weight: f32) -> Option<GuideFeatures> {
    if weight == 0.0 || !features.flat {
        return None;
    }
    let mut guided = features.clone();
    let first = guided.set.planes.len();
    let logarithm = |v: &f32| weight * (v + 0.02).max(0.01).ln();
    guided.set.planes.extend(picture.channels().iter().map(|plane| plane.iter().map(logarithm).collect()));
    guided.set.groups.push(first..first + 3);
    guided.surfaces.extend(first..first + 3);
    Some(guided)
}
