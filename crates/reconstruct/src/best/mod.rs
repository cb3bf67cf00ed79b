//! The project's own method: light split into a low layer and events, rebuilt in two passes of collaborative
//! regression, each pixel by the candidate that predicts the other half best.
//!
//! Steps, one file each: what exceeds its surroundings goes to a sparse layer (`split`); features are freed of noise
//! (`features`); a first regression guided by the other half (`first_pass`); the sparse layer is spread over pixels
//! that resemble its own (`spread`); what the residual still holds is added (`cascade`), which makes a pilot picture; a
//! second regression is guided by the pilot (`second_pass`); and the candidates are mixed by their error (`choice`).

mod cascade;
mod choice;
mod features;
mod first_pass;
mod guided_kernel;
mod second_pass;
mod settings;
mod split;
mod spread;
#[cfg(test)]
mod test_scene;

use stack::{Component, FeatureStack, Image, Monitor};

use crate::box_filter::box_mean;
use crate::pipeline::{ReconstructError, Reconstruction};

pub use features::{GuideFeatures, guide_features};
pub use settings::BestSettings;

/// Rebuilds the scattered light `component` of `stack`.
///
/// # Errors
/// When its noise does not come in buckets, or `monitor` cancels.
pub fn rebuild(
    stack: &FeatureStack,
    component: &Component,
    features: &GuideFeatures,
    settings: &BestSettings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    monitor.begin("spikes", 1);
    let layers = split::split(component, &stack.samples, &settings.split)?;
    let noise = relative_noise(&layers);
    let first = first_pass::first_pass(&layers, &noise, features, &settings.regression, monitor)?;
    monitor.begin("spread", 1);
    let spread = spread::spread(&layers.events, &mean_of(&first), features, &settings.spread);
    let mut pilot = mean_of(&first);
    pilot.add(&spread);
    cascade::add_significant_residual(&mut pilot, component, &stack.samples, features, &settings.cascade, monitor)?;
    let second = second_pass::Guidance { pilot: &pilot, first: &first, noise: &noise };
    let mut candidates = vec![first.clone()];
    candidates.extend(second_pass::second_pass(&layers, &second, features, &settings.regression, monitor)?);
    monitor.begin("choice", 1);
    let chosen = choice::choose(&candidates, &layers, &pilot, features, &settings.choice);
    let mut picture = mean_of(&chosen.halves);
    picture.add(&spread);
    picture.channels_mut().iter_mut().flatten().for_each(|v| *v = v.max(0.0));
    Ok(Reconstruction {
        mse: chosen.mse,
        spikes: Some(layers.events.light),
        marked: layers.events.energy.iter().filter(|e| **e > 0.0).count(),
        ..Reconstruction::plain(picture)
    })
}

/// Mean of two halves.
fn mean_of(halves: &[Image; 2]) -> Image {
    let [a, b] = [0, 1].map(|half: usize| halves[half].channels());
    let channels = a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect());
    Image::from_channels(halves[0].size(), channels.collect())
}

/// ν = variance of a half relative to the squared luminance L² + 0.001 around it, both over 5×5 pixels.
fn relative_noise(layers: &split::Layers) -> Vec<f32> {
    let size = layers.variance.size();
    let luminance = box_mean(&luminance(&mean_of(&layers.halves)), size, 2);
    let relative = |(i, l): (usize, &f32)| layers.variance.mean_at(i) / (l * l + 1e-3);
    box_mean(&luminance.iter().enumerate().map(relative).collect::<Vec<f32>>(), size, 2)
}

/// Mean over RGB of every pixel.
fn luminance(image: &Image) -> Vec<f32> {
    (0..image.pixels()).map(|pixel| image.mean_at(pixel)).collect()
}

#[cfg(test)]
mod tests;
