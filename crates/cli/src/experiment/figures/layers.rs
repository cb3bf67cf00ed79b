//! Pictures that the figures show beside their results.

use stack::{FeatureRole, Image, Size};

use super::features::planes;
use super::outcome::Outcome;
use super::subject::Subject;

/// A picture of something inside a reconstruction; `None` when the method has no such thing.
pub struct Layer {
    /// Name in the file's name.
    pub name: &'static str,
    /// Whether it is light, to be shown at the picture's exposure.
    pub is_light: bool,
    /// How it is found.
    pub of: fn(&Outcome, &Subject) -> Option<Image>,
}

/// How much the replaced pixels were changed, up or down.
pub const SPIKES: Layer = Layer {
    name: "spikes",
    is_light: true,
    of: |o, _| {
        let mut spikes = o.found.spikes.clone()?;
        spikes.channels_mut().iter_mut().flatten().for_each(|value| *value = value.abs());
        Some(spikes)
    },
};

/// Prefiltered visibility.
pub const VISIBILITY: Layer = Layer {
    name: "visibility",
    is_light: false,
    of: |o, subject| {
        let settings = &o.settings.reconstruction.prefilter;
        let planes = planes(&subject.case.stack, settings, &[FeatureRole::Visibility])?;
        Some(grey(subject.case.stack.size(), planes.first()?, |v| 0.5 * v + 0.5))
    },
};

/// Shared bandwidth h: black is 0, white 1 and more.
pub const BANDWIDTH_MAP: Layer = Layer {
    name: "bandwidth",
    is_light: false,
    of: |o, subject| Some(grey(subject.case.stack.size(), o.found.bandwidth.as_ref()?, |h| h)),
};

/// Rank k: black is 0, white 10.
pub const RANK_MAP: Layer = Layer {
    name: "rank",
    is_light: false,
    of: |o, subject| Some(grey(subject.case.stack.size(), o.found.rank.as_ref()?, |k| k / 10.0)),
};

/// Root of the estimated relative MSE: white is 1 and more.
pub const ERROR_MAP: Layer = Layer {
    name: "error",
    is_light: false,
    of: |o, subject| {
        let picture = &o.found.picture;
        let relative = o.found.mse.iter().enumerate().map(|(i, mse)| mse / (picture.mean_at(i).powi(2) + 0.001));
        Some(grey(subject.case.stack.size(), &relative.collect::<Vec<_>>(), f32::sqrt))
    },
};

fn grey(size: Size, plane: &[f32], shade: impl Fn(f32) -> f32) -> Image {
    Image::from_channels(size, vec![plane.iter().map(|v| shade(*v)).collect(); 3])
}
