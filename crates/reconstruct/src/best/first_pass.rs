//! The first regression: each half guided by the other.

use stack::{Cancelled, Image, Monitor};

use super::crossed::Crossed;
use super::given::Given;
use super::halves::halves_of;
use super::settings::FitSettings;

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
    let Given { low, noise, samples, features } = given;
    let size = features.set.size;
    let crossed = Crossed {
        size,
        features: &features.set.planes,
        halves: low.halves.each_ref().map(Image::channels),
        variances: low.variance.channels(),
        noise,
        importance: samples.as_deref(),
    };
    let images = images.each_ref().map(Image::channels);
    Ok(halves_of(size, crossed.fit(images, settings, "first pass", monitor)?))
}

#[cfg(test)]
mod tests;
