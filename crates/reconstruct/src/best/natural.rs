//! The scales on which features are compared.

use rayon::prelude::*;
use stack::{FeatureRole, Image};

use super::settings::FeatureSettings;
use crate::variance::smoothed;

/// Added to every variance: differences below its root are averaged away even where there is no noise.
const LEAST_VARIANCE: f32 = 1e-6;

/// Factor from a range of [−1, 1] to the natural one.
pub fn natural_scale(role: FeatureRole) -> f32 {
    if role == FeatureRole::Normal { 1.0 } else { 0.5 }
}

/// The `variance` of a feature on its natural `scale`, smoothed. `None` where nothing is known of it.
pub fn natural_variances(variance: &Image, scale: f32, settings: &FeatureSettings) -> Option<Vec<Vec<f32>>> {
    let mut variances = smoothed(variance, settings.variance_radius)?.into_channels();
    variances.par_iter_mut().flatten().for_each(|v| *v = scale * scale * *v + LEAST_VARIANCE);
    Some(variances)
}
