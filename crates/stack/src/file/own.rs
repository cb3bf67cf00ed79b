//! Reads what Tamis wrote.

use super::counts::{Spp, rounded};
use super::exr_read::MOST_CHANNELS;
use super::found::{Found, FoundRole};
use super::layers::METADATA;
use super::loaded::{Loaded, Plane, take_image};
use super::role::Role;
use super::write::{SAMPLES, bucket_layer, input_layers};
use super::{FileError, Layers, ReadStack, StackHeader};
use crate::{
    Component, ComponentRole, Dealing, Estimate, Feature, FeatureRole, FeatureStack, GATHERED, INDIRECT, Image, Noise,
    SampleCounts,
};

/// Layers that a reconstruction makes; they are results, never inputs.
const RESULTS: [&str; 8] = ["R", "G", "B", "spikes.", "mse.", "bandwidth.", "rank.", "beauty."];

/// Whether a file is one of ours that holds what a reconstruction starts from.
pub fn is_own(layers: &Layers) -> bool {
    layers.metadata.is_some() && layers.has("noisy.R")
}

/// What a file of ours says about itself; nothing of another program's.
///
/// # Errors
/// When that cannot be.
pub fn header_of(layers: &Layers) -> Result<Option<StackHeader>, FileError> {
    let header: Option<StackHeader> = layers.metadata.clone().and_then(|json| serde_json::from_value(json).ok());
    match header.as_ref().and_then(contradiction) {
        Some(what) => Err(contradictory(layers, &what)),
        None => Ok(header),
    }
}

/// What is wrong with how `header` deals samples to buckets. Everything that counts them relies on it.
fn contradiction(header: &StackHeader) -> Option<String> {
    let StackHeader { sequences, buckets, per_bucket, .. } = header;
    if *sequences == 0 || *buckets == 0 || buckets % sequences != 0 {
        return Some(format!(
            "{buckets} buckets of {sequences} sequences; expected one sequence or more, of equally many buckets"
        ));
    }
    if *buckets as usize > MOST_CHANNELS {
        return Some(format!("{buckets} buckets; expected no more than {MOST_CHANNELS}"));
    }
    let counts = per_bucket.as_ref()?;
    if counts.len() != *buckets as usize {
        return Some(format!("the samples of {} buckets; expected those of {buckets}", counts.len()));
    }
    let sum = counts.iter().try_fold(0, |sum: u32, count| sum.checked_add(*count));
    sum.is_none().then(|| format!("more samples in all buckets than {}", u32::MAX))
}

fn contradictory(layers: &Layers, what: &str) -> FileError {
    let reason = format!("its attribute {METADATA} says {what}");
    FileError::Damaged { path: layers.path.clone(), format: "OpenEXR", reason }
}

/// Reads a stack of ours.
///
/// # Errors
/// When it is not whole.
pub fn read_own(mut layers: Layers, header: StackHeader) -> Result<ReadStack, FileError> {
    let samples = take_counts(&mut layers, &header)?;
    let mut components = Vec::new();
    for role in ComponentRole::ALL {
        let buckets = header.buckets as usize;
        if let Some(radiance) = take_estimate(&mut layers, role.layer(), &["R", "G", "B"], buckets, &samples) {
            components.push(Component { role, radiance });
        }
    }
    if components.is_empty() {
        return Err(missing("colour", "noisy.R noisy.G noisy.B and their buckets", &layers));
    }
    let [indirect, gathered] = [INDIRECT, GATHERED]
        .map(|layer| take_estimate(&mut layers, layer, &["R", "G", "B"], header.buckets as usize, &samples));
    let mut features = Vec::new();
    for role in FeatureRole::ALL {
        let many = layers.has(&format!("{}.bucket0.{}", role.layer(), role.channels()[0]));
        let buckets = if many { header.buckets } else { header.buckets.min(2) } as usize;
        if let Some(estimate) = take_estimate(&mut layers, role.layer(), role.channels(), buckets, &samples) {
            features.push(Feature { role, estimate });
        }
    }
    layers.channels.retain(|channel| !is_result(&channel.name) && !belongs(&channel.name, SAMPLES));
    let Layers { window, film, channels: passthrough, carried, .. } = layers;
    let stack = FeatureStack { window, film, samples, components, indirect, gathered, features, passthrough };
    let found = found_in(&stack, header.samples_unknown);
    Ok(ReadStack { stack, header: Some(header), notes: found.lines(), found, carried })
}

fn take_counts(layers: &mut Layers, header: &StackHeader) -> Result<SampleCounts, FileError> {
    let plane = |layers: &mut Layers, layer: &str| -> Option<Vec<u32>> {
        Some(rounded(&layers.take(&format!("{layer}.Y"))?, 1.0))
    };
    let total = plane(layers, SAMPLES).ok_or_else(|| missing("sample counts", "samples.Y", layers))?;
    let most = total.iter().copied().max().unwrap_or(0);
    if header.first.checked_add(most).is_none() {
        let (first, last) = (header.first, u32::MAX);
        return Err(contradictory(layers, &format!("{first} for its first sample; {most} of them end after {last}")));
    }
    let buckets = header.buckets as usize;
    let planes: Option<Vec<_>> = (0..buckets).map(|b| plane(layers, &bucket_layer(SAMPLES, b, buckets))).collect();
    let dealing = match (&header.per_bucket, planes) {
        (Some(counts), _) => Dealing::PerBucket(counts.clone()),
        (None, Some(planes)) if buckets > 1 => Dealing::PerPixel(planes),
        _ => Dealing::Numbered { sequences: header.sequences, buckets: header.buckets },
    };
    Ok(SampleCounts { first: header.first, total, dealing })
}

fn missing(wanted: &'static str, expected: &str, layers: &Layers) -> FileError {
    FileError::Missing { path: layers.path.clone(), wanted, expected: expected.into(), found: layers.names() }
}

/// What there is to say of a stack of ours, whose number of samples may be unknown.
pub fn found_in(stack: &FeatureStack, samples_unknown: bool) -> Found {
    let role = |role: &str, layer: &str, channels: &[&str]| FoundRole {
        role: role.into(),
        channels: full_names(layer, channels),
        noise: String::new(),
        from: None,
        guessed: false,
    };
    let component = |c: &Component| {
        let name = if c.role == ComponentRole::Scattered { Role::Colour.name() } else { c.role.layer() };
        role(name, c.role.layer(), &["R", "G", "B"])
    };
    let roles = stack.components.iter().map(component);
    let light = stack.parts_of_light().map(|(layer, _)| role(layer, layer, &["R", "G", "B"]));
    let features = stack.features.iter().map(|f| role(f.role.layer(), f.role.layer(), f.role.channels()));
    let spp = || Spp { total: stack.samples.total.clone(), from: "samples.Y".into() }.found();
    let mut found = Found { renderer: "Tamis".into(), spp: (!samples_unknown).then(spp), ..Found::default() };
    found.roles = roles.chain(light).chain(features).collect();
    found.conclude(stack);
    found
}

fn full_names(layer: &str, channels: &[&str]) -> Vec<String> {
    channels.iter().map(|channel| format!("{layer}.{channel}")).collect()
}

/// An estimate: from its buckets when all are there, else its mean, with its variance where there is one.
fn take_estimate(
    layers: &mut Layers,
    layer: &str,
    channels: &[&str],
    buckets: usize,
    samples: &SampleCounts,
) -> Option<Estimate> {
    let mean = take_image(layers, &full_names(layer, channels))?;
    let all: Option<Vec<Image>> =
        (0..buckets).map(|b| take_image(layers, &full_names(&bucket_layer(layer, b, buckets), channels))).collect();
    if let Some(buckets) = all.filter(|_| buckets > 1) {
        return Some(Estimate::from_buckets(buckets, samples));
    }
    let variance = take_image(layers, &full_names(&format!("{layer}Variance"), channels));
    Some(Estimate { mean, noise: variance.map_or(Noise::Unknown, Noise::VarianceOfMean) })
}

/// A render of ours as one bucket among others: its components are one, and only its means count. Where the number of its
/// samples is unknown, its counts are no number of samples.
pub fn load_own(mut layers: Layers, samples_unknown: bool) -> Loaded {
    let mut colour = Image::zeros(layers.window.size, 3);
    for role in ComponentRole::ALL {
        let part = take_image(&mut layers, &full_names(role.layer(), &["R", "G", "B"]));
        part.iter().for_each(|part| colour.add(part));
    }
    let plane = |role, mean| Plane { role, mean, halves: None, measured: None };
    let mut planes = vec![plane(Role::Colour, colour)];
    for role in FeatureRole::ALL {
        let mean = take_image(&mut layers, &full_names(role.layer(), role.channels()));
        planes.extend(mean.map(|mean| plane(Role::Feature(role), mean)));
    }
    let total = layers.take("samples.Y").filter(|_| !samples_unknown);
    let spp = total.map(|total| Spp { total: rounded(&total, 1.0), from: "samples.Y".into() });
    layers.channels.retain(|channel| !is_own_channel(&channel.name));
    let mut found = Found { renderer: "Tamis".into(), spp: spp.as_ref().map(Spp::found), ..Found::default() };
    found.roles = planes
        .iter()
        .map(|p| FoundRole {
            role: p.role.name().into(),
            channels: Vec::new(),
            noise: String::new(),
            from: None,
            guessed: false,
        })
        .collect();
    Loaded { planes, spp, found, rest: layers, own: true }
}

/// Whether a file of ours has the channel `name` for an input or a result.
pub fn is_own_channel(name: &str) -> bool {
    is_result(name) || input_layers().any(|layer| belongs(name, layer))
}

/// Whether the channel `name` is of `layer`: its mean, or what tells its noise.
pub fn belongs(name: &str, layer: &str) -> bool {
    let own = |rest: &str| [".", "A.", "B.", "Variance."].iter().any(|form| rest.starts_with(form));
    name.strip_prefix(layer).is_some_and(own)
}

/// Whether the channel `name` of a file of ours is what a reconstruction made.
pub fn is_result(name: &str) -> bool {
    RESULTS.iter().any(|r| if r.ends_with('.') { name.starts_with(r) } else { name == *r })
}
