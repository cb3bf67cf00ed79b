//! Everything up to the second pass.

use std::borrow::Cow;
use std::ops::Range;

use stack::{Cancelled, Component, FeatureStack, Image, Monitor, Noise, SampleCounts};

use super::alone::split_alone;
use super::cascade::{Parts, add_significant_residual, relative_to};
use super::choice::Contest;
use super::features::GuideFeatures;
use super::given::Given;
use super::guided_kernel::GuidedKernel;
use super::halves::{luminance, mean_of};
use super::light_guide::with_colour;
use super::passes::{Pass, low_layers, through_first_pass};
use super::settings::{BestSettings, FitSettings};
use super::split::{self, Layers};
use super::{first_pass, second_pass, spread};
use crate::bands::{image_rows, rows_of};
use crate::box_filter::box_mean;
use crate::per_pixel::plane;
use crate::reconstruction::ReconstructError;
use crate::recorruption::evenly_recorrupted_halves;
use crate::variance::known_everywhere;

/// Everything up to the second pass.
#[derive(Clone)]
pub struct Piloted<'a> {
    pub features: Cow<'a, GuideFeatures>,
    /// The same with colours, where they alone do not tell surfaces apart.
    pub coloured: Option<GuideFeatures>,
    pub layers: Layers,
    /// Relative noise ν.
    pub noise: Vec<f32>,
    /// Samples of every pixel over their mean, where that counts.
    pub samples: Option<Vec<f32>>,
    /// Spread events.
    pub spread: Image,
    pub event_variance: Vec<f32>,
    /// What guides the second pass.
    pub pilot: Image,
    /// Both halves of the first pass.
    pub first: [Image; 2],
    /// Passes, and last what the light has beside them; nothing when none are asked for.
    pub passes: Vec<Pass>,
}

impl<'a> Piloted<'a> {
    /// All steps up to the second pass; `beside` is light of the same picture that was rebuilt before.
    pub fn new(
        stack: &FeatureStack,
        component: Cow<'_, Component>,
        features: &'a GuideFeatures,
        beside: Option<&Image>,
        settings: &BestSettings,
        passes: &[Image],
        monitor: &dyn Monitor,
    ) -> Result<Self, ReconstructError> {
        monitor.begin("spikes", 1);
        let layers = layers_of(&component, stack, settings)?;
        let parts = parts_of(&component, &stack.samples, settings.cascade.parts);
        let low = match passes {
            [] => Vec::new(),
            passes => low_layers(passes, &component.radiance.mean, &mean_of(&layers.halves)),
        };
        drop(component);
        let noise = relative_noise(&layers);
        let samples = share_of_samples(&stack.samples, &settings.regression);
        let given = Given { layers: &layers, noise: &noise, samples: samples.as_deref(), features };
        let first = first_pass::first_pass(&layers.halves, &given, &settings.regression, monitor)?;
        let passes = through_first_pass(low, &given, &settings.regression, monitor)?;
        monitor.begin("spread", 1);
        let mut pilot = mean_of(&first);
        let coloured = with_colour(features, &pilot, settings.colour.guide);
        let surfaces = coloured.as_ref().unwrap_or(features);
        let lit = with_share(&pilot, beside, settings.light.direct_spread);
        let events = spread::spread(&layers.events, &lit, surfaces, &settings.spread);
        drop(lit);
        let spread = spread::steadied(events.halves, &pilot, surfaces, &settings.spread, monitor)?;
        pilot.add(&spread);
        if let Some(parts) = parts {
            let kernel = GuidedKernel::surfaces(surfaces, settings.cascade.feature_scale);
            let relative = relative_to(&pilot);
            let scrutiny = settings.cascade.scrutiny(parts.count());
            add_significant_residual(&mut pilot, parts, relative, |step| kernel.taps(step), scrutiny, monitor)?;
        }
        let (features, event_variance) = (Cow::Borrowed(features), events.variance);
        Ok(Self { features, coloured, layers, noise, samples, spread, event_variance, pilot, first, passes })
    }

    /// Some rows of all that.
    pub fn rows(&self, rows: &Range<usize>) -> Piloted<'static> {
        let plane = |plane: &Vec<f32>| rows_of(plane, self.pilot.size(), rows);
        Piloted {
            features: Cow::Owned(self.features.rows(rows)),
            coloured: self.coloured.as_ref().map(|features| features.rows(rows)),
            layers: self.layers.rows(rows),
            noise: plane(&self.noise),
            samples: self.samples.as_ref().map(plane),
            spread: image_rows(&self.spread, rows),
            event_variance: plane(&self.event_variance),
            pilot: image_rows(&self.pilot, rows),
            first: self.first.each_ref().map(|half| image_rows(half, rows)),
            passes: self.passes.iter().map(|pass| pass.rows(rows)).collect(),
        }
    }

    /// What both regressions make of two `images`: the `first` of it, and the candidates of the second pass.
    pub fn candidates(
        &self,
        images: &[Image; 2],
        first: &[Image; 2],
        settings: &FitSettings,
        monitor: &dyn Monitor,
    ) -> Result<Vec<[Image; 2]>, Cancelled> {
        let Self { features, layers, noise, samples, .. } = self;
        let given = Given { layers, noise, samples: samples.as_deref(), features };
        let mut candidates = second_pass::second_pass(images, &given, &self.pilot, &self.first, settings, monitor)?;
        candidates.insert(0, first.clone());
        Ok(candidates)
    }

    /// What tells surfaces apart.
    pub fn surfaces(&self) -> &GuideFeatures {
        self.coloured.as_ref().unwrap_or(&self.features)
    }

    pub fn contest<'b>(&'b self, candidates: &'b [[Image; 2]]) -> Contest<'b> {
        let Self { layers, pilot, .. } = self;
        Contest { candidates, layers, pilot, features: self.surfaces() }
    }
}

/// `picture` and `share` of what is `beside` it.
fn with_share<'a>(picture: &'a Image, beside: Option<&Image>, share: f32) -> Cow<'a, Image> {
    let Some(beside) = beside.filter(|_| share > 0.0) else { return Cow::Borrowed(picture) };
    let mut sum = picture.clone();
    for (sum, plane) in sum.channels_mut().iter_mut().zip(beside.channels()) {
        sum.iter_mut().zip(plane).for_each(|(sum, v)| *sum += share * v);
    }
    Cow::Owned(sum)
}

/// Both layers: by buckets where there are any, else by what is known of the mean.
pub fn layers_of(
    component: &Component,
    stack: &FeatureStack,
    settings: &BestSettings,
) -> Result<Layers, ReconstructError> {
    match &component.radiance.noise {
        Noise::VarianceOfMean(variance) => Ok(split_alone(&component.radiance.mean, variance)),
        _ => split::split(component, &stack.samples, &settings.split),
    }
}

/// Independent parts of a component for the cascade.
fn parts_of(component: &Component, samples: &SampleCounts, most: usize) -> Option<Parts> {
    let radiance = &component.radiance;
    match &radiance.noise {
        Noise::VarianceOfMean(variance) => {
            let variance = known_everywhere(variance.clone(), &radiance.mean);
            Some(Parts::halves(&evenly_recorrupted_halves(&radiance.mean, &variance)))
        }
        _ => radiance.groups(samples, most).map(|groups| Parts::new(groups, samples)),
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
pub fn relative_noise(layers: &Layers) -> Vec<f32> {
    let size = layers.variance.size();
    let luminance = box_mean(&luminance(&mean_of(&layers.halves)), size, 2);
    let relative = |pixel: usize| layers.variance.mean_at(pixel) / (luminance[pixel] * luminance[pixel] + 1e-3);
    box_mean(&plane(size.pixels(), relative), size, 2)
}
