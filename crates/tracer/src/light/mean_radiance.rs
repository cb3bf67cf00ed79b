//! Radiance as one number, to choose lights by.

use glam::Vec3;

/// Mean of the channels; 0 for a radiance nobody could mean.
pub(crate) fn mean(radiance: Vec3) -> f64 {
    let mean = f64::from(radiance.element_sum()) / 3.0;
    if mean.is_finite() && mean > 0.0 { mean } else { 0.0 }
}
