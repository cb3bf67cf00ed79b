//! The first regression: each half guided by the other.

use stack::{Cancelled, Image, Monitor};

use super::given::Given;
use super::halves::halves_of;
use super::settings::FitSettings;
use crate::collaborative::{Fitted, Guides, Kernel, Ridge, collaborate, units};
use crate::patch_distance::Comparison;

/// Two `images`, the first rebuilt with weights from the second half of the low layer and the second with weights from the
/// first. Reports the stage `first pass`.
///
/// # Errors
/// When `monitor` cancels.
pub fn first_pass(
    images: &[Image; 2],
    given: &Given,
    settings: &FitSettings,
    monitor: &dyn Monitor,
) -> Result<[Image; 2], Cancelled> {
    let Given { layers, noise, samples, features } = *given;
    let size = features.set.size;
    let colours = [0, 1].map(|half: usize| layers.halves[half].channels());
    let planes = images.each_ref().map(|image| image.channels().iter().map(Vec::as_slice).collect::<Vec<_>>());
    let fitted = Fitted {
        features: &features.set.planes,
        responses: &[&planes[0], &planes[1]],
        importance: samples,
        noise,
        ridge: Ridge { least: settings.ridge, per_noise: settings.ridge_noise },
        stride: settings.stride,
        covered: settings.covered,
    };
    let guides = Guides {
        size,
        values: &[colours[1], colours[0]],
        variances: layers.variance.channels(),
        comparison: Comparison { patch_radius: 2, epsilon: 1e-8, noise_taken_off: 1.0 },
        radius: settings.first_radius,
    };
    let kernel = Kernel { bandwidth: settings.first_bandwidth, sigma: f32::INFINITY };
    monitor.begin("first pass", units(size, settings.stride, settings.covered));
    let predicted = collaborate(&fitted, &guides, &[kernel], monitor)?;
    Ok(halves_of(size, predicted.into_iter().flatten().collect()))
}

#[cfg(test)]
mod tests;
