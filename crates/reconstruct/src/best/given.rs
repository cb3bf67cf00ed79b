//! What all regressions of a component rest on.

use std::borrow::Cow;
use std::ops::Range;

use stack::SampleCounts;

use super::features::CleanFeatures;
use super::halves::{luminance, mean_of};
use super::settings::FitSettings;
use super::split::LowLayer;
use crate::bands::rows_of;
use crate::box_filter::box_mean;
use crate::per_pixel::plane;

/// What all regressions of a component rest on.
#[derive(Clone)]
pub struct Given<'a> {
    /// What is rebuilt, with its noise.
    pub low: LowLayer,
    /// Relative noise ν of a half: see [`relative_noise`].
    pub noise: Vec<f32>,
    /// Samples of every pixel over their mean, where that counts.
    pub samples: Option<Vec<f32>>,
    /// What explains it.
    pub features: Cow<'a, CleanFeatures>,
}

impl<'a> Given<'a> {
    /// A layer whose pixels have so many samples (`counts`), explained by `features`.
    pub fn new(low: LowLayer, counts: &SampleCounts, features: &'a CleanFeatures, settings: &FitSettings) -> Self {
        let (noise, samples) = (relative_noise(&low), share_of_samples(counts, settings));
        Self { low, noise, samples, features: Cow::Borrowed(features) }
    }

    /// Some `rows` of all that.
    pub fn rows(&self, rows: &Range<usize>) -> Given<'static> {
        let plane = |plane: &Vec<f32>| rows_of(plane, self.features.set.size, rows);
        Given {
            low: self.low.rows(rows),
            noise: plane(&self.noise),
            samples: self.samples.as_ref().map(plane),
            features: Cow::Owned(self.features.rows(rows)),
        }
    }
}

/// Samples of every pixel over their mean; `None` where they do not count or do not differ.
fn share_of_samples(counts: &SampleCounts, settings: &FitSettings) -> Option<Vec<f32>> {
    if !settings.weigh_samples || counts.is_uniform() {
        return None;
    }
    let (mean, ..) = counts.mean_min_max();
    let share = |n: &u32| (f64::from((*n).max(1)) / mean) as f32;
    Some(counts.total.iter().map(share).collect())
}

/// ν = variance of a half relative to the squared luminance L² + 0.001 around it, both over 5×5 pixels.
pub fn relative_noise(low: &LowLayer) -> Vec<f32> {
    let size = low.variance.size();
    let luminance = box_mean(&luminance(&mean_of(&low.halves)), size, 2);
    let relative = |pixel: usize| low.variance.mean_at(pixel) / (luminance[pixel] * luminance[pixel] + 1e-3);
    box_mean(&plane(size.pixels(), relative), size, 2)
}
