//! Components of a picture, one by one and added up.

use stack::{Component, Image, SampleCounts, Size};

use crate::reconstruction::{ReconstructError, Reconstruction};
use crate::variance::known_everywhere;

/// What `rebuild` makes of every component that is not black, added up.
pub fn sum_of_components(
    size: Size,
    components: &[Component],
    rebuild: impl Fn(&Component) -> Result<Reconstruction, ReconstructError>,
) -> Result<Reconstruction, ReconstructError> {
    let mut sum = Reconstruction::plain(Image::zeros(size, 3));
    for component in components.iter().filter(|component| is_lit(component)) {
        sum.add(rebuild(component)?);
    }
    Ok(sum)
}

/// Whether there is anything in `component`.
pub fn is_lit(component: &Component) -> bool {
    component.radiance.mean.channels().iter().any(|plane| plane.iter().any(|v| *v != 0.0))
}

/// Variance of the mean of `component`, whose pixels have so many samples (`counts`), known everywhere.
pub fn variance_of(component: &Component, counts: &SampleCounts) -> Result<Image, ReconstructError> {
    let variance = component
        .radiance
        .variance_of_mean(counts)
        .ok_or(ReconstructError::NoiseUnknown { layer: component.role.layer() })?;
    Ok(known_everywhere(variance, &component.radiance.mean))
}
