//! A film as a feature stack, and back.

use std::ops::Range;

use stack::{
    Component, ComponentRole, Dealing, Estimate, Feature, FeatureRole, FeatureStack, GATHERED, INDIRECT, Image, Noise,
    SampleCounts,
};

use super::sample::{self, FEATURE_CHANNELS, RADIANCE_CHANNELS};
use super::{Film, NotAFilm, feature_groups};

/// Channels of each component in a bucket's image.
fn component_channels() -> impl Iterator<Item = (ComponentRole, Range<usize>)> {
    ComponentRole::ALL.into_iter().enumerate().map(|(i, role)| (role, 3 * i..3 * i + 3))
}

/// Channels of each feature in a group's image.
fn feature_channels() -> impl Iterator<Item = (FeatureRole, Range<usize>)> {
    FeatureRole::ALL.into_iter().scan(0, |next, role| {
        let first = *next;
        *next += role.channels().len();
        Some((role, first..*next))
    })
}

/// Takes `channels` out of every group's image.
fn cut(groups: &mut [Image], channels: Range<usize>, counts: &SampleCounts) -> Estimate {
    let cut = |image: &mut Image| {
        let size = image.size();
        let channels = image.channels_mut()[channels.clone()].iter_mut().map(std::mem::take).collect();
        Image::from_channels(size, channels)
    };
    Estimate::from_buckets(groups.iter_mut().map(cut).collect(), counts)
}

impl Film {
    /// The film as a feature stack: both components, indirect and gathered light with all buckets, all features as halves
    /// (without noise when there is only one bucket).
    pub fn to_stack(&self) -> FeatureStack {
        let Self { window, size, ref counts, ref radiance, ref features, .. } = *self;
        let [radiance, features] = [radiance, features].map(Clone::clone);
        Self { window, size, counts: counts.clone(), radiance, features, leaving: Vec::new() }.into_stack()
    }

    /// [`to_stack`](Self::to_stack) without a copy.
    pub fn into_stack(mut self) -> FeatureStack {
        let counts = &self.counts;
        let components = component_channels()
            .map(|(role, channels)| Component { role, radiance: cut(&mut self.radiance, channels, counts) })
            .collect();
        let [indirect, gathered] =
            [sample::INDIRECT, sample::GATHERED].map(|channels| Some(cut(&mut self.radiance, channels, counts)));
        let features = feature_channels()
            .map(|(role, channels)| Feature { role, estimate: cut(&mut self.features, channels, counts) })
            .collect();
        FeatureStack {
            window: self.window,
            film: self.size,
            samples: self.counts,
            components,
            indirect,
            gathered,
            features,
            passthrough: vec![],
        }
    }

    /// The film that [`to_stack`](Self::to_stack) made `stack` from, to add more samples to. Layers it does not know
    /// (`passthrough`) are dropped, and light is gathered anew.
    ///
    /// # Errors
    /// When `stack` does not hold all that a film consists of.
    pub fn from_stack(stack: FeatureStack) -> Result<Self, NotAFilm> {
        let buckets = check_counts(&stack)?;
        let groups = feature_groups(buckets);
        let mut radiance = vec![Vec::with_capacity(RADIANCE_CHANNELS); buckets];
        let mut features = vec![Vec::with_capacity(FEATURE_CHANNELS); groups];
        let size = stack.window.size;
        let mut components = stack.components;
        for role in ComponentRole::ALL {
            let found = components.iter().position(|c| c.role == role).map(|i| components.swap_remove(i).radiance);
            append(&mut radiance, found, role.layer(), 3, size)?;
        }
        append(&mut radiance, stack.indirect, INDIRECT, 3, size)?;
        append(&mut radiance, stack.gathered, GATHERED, 3, size)?;
        let mut all = stack.features;
        for role in FeatureRole::ALL {
            let found = all.iter().position(|f| f.role == role).map(|i| all.swap_remove(i).estimate);
            append(&mut features, found, role.layer(), role.channels().len(), size)?;
        }
        let images = |groups: Vec<Vec<Vec<f32>>>| groups.into_iter().map(|g| Image::from_channels(size, g)).collect();
        Ok(Self {
            window: stack.window,
            size: stack.film,
            counts: stack.samples,
            radiance: images(radiance),
            features: images(features),
            leaving: super::no_light(groups),
        })
    }
}

/// Checks sample counts; how many buckets there are.
fn check_counts(stack: &FeatureStack) -> Result<usize, NotAFilm> {
    let Dealing::Numbered { sequences, buckets } = stack.samples.dealing else {
        return Err(NotAFilm::new("the dealing of samples", "numbered", "another renderer's"));
    };
    if sequences == 0 || buckets == 0 || buckets % sequences != 0 {
        return Err(NotAFilm::new("the number of buckets", format!("a multiple of {sequences} sequences"), buckets));
    }
    let (pixels, counted) = (stack.window.size.pixels(), stack.samples.total.len());
    if counted != pixels {
        return Err(NotAFilm::new("the number of counted pixels", pixels, counted));
    }
    Ok(buckets as usize)
}

/// Appends the channels of each of an estimate's groups to `groups`.
fn append(
    groups: &mut [Vec<Vec<f32>>],
    estimate: Option<Estimate>,
    layer: &str,
    channels: usize,
    size: stack::Size,
) -> Result<(), NotAFilm> {
    let Some(estimate) = estimate else {
        return Err(NotAFilm::new(format!("layer '{layer}'"), "there", "none"));
    };
    let images = match estimate.noise {
        Noise::Buckets(images) => images,
        Noise::Unknown | Noise::VarianceOfMean(_) => vec![estimate.mean],
    };
    if images.len() != groups.len() {
        return Err(NotAFilm::new(format!("the number of parts of layer '{layer}'"), groups.len(), images.len()));
    }
    for (group, image) in groups.iter_mut().zip(images) {
        if image.size() != size || image.channels().len() != channels {
            let found = format!("{} of {}", image.channels().len(), image.size());
            return Err(NotAFilm::new(format!("channels of layer '{layer}'"), format!("{channels} of {size}"), found));
        }
        group.append(&mut image.into_channels());
    }
    Ok(())
}
