//! The paper's method: spikes, prefilter, regression (its figure 2).

#[cfg(test)]
mod alternatives;

use stack::{Cancelled, Image, Monitor};

use crate::Settings;
use crate::prefilter::FeatureSet;
use crate::reconstruction::Reconstruction;
use crate::regression::{RegressionInput, regress};
use crate::spikes::{SpikeFree, remove_spikes};

/// Rebuilds scattered light: `radiance`, three channels, with the `variance` of its mean, guided by prefiltered
/// `features`.
///
/// # Errors
/// When `monitor` cancels.
pub fn rebuild(
    radiance: &Image,
    variance: &Image,
    features: &FeatureSet,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, Cancelled> {
    let SpikeFree { colour, variance, spikes, marked } = remove_spikes(radiance, variance, &settings.spikes, monitor)?;
    let input = RegressionInput { colour: &colour, variance: &variance, features, active: None };
    let regression = regress(&input, &settings.regression, monitor)?;
    Ok(Reconstruction {
        mse: regression.mse,
        spikes: Some(spikes),
        marked: marked.iter().filter(|marked| **marked).count(),
        bandwidth: Some(regression.bandwidth),
        rank: Some(regression.rank),
        ..Reconstruction::plain(regression.picture)
    })
}
