//! Writes a feature stack with whatever results belong to it.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::borrowed::BorrowedSamples;
use super::write_channels::{Frame, write_channels};
use super::{Carried, FileError};
use crate::merge::Record;
use crate::{
    ComponentRole, Dealing, Estimate, FeatureRole, FeatureStack, GATHERED, INDIRECT, Image, Noise, SampleCounts,
};

/// Layer of sample counts.
pub(super) const SAMPLES: &str = "samples";

/// What a stack's file says about itself, beside its channels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StackHeader {
    /// Number of the first sample.
    pub first: u32,
    /// Independently scrambled sequences.
    pub sequences: u32,
    /// Buckets.
    pub buckets: u32,
    /// Samples of each bucket, where these do not follow from their number alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub per_bucket: Option<Vec<u32>>,
    /// Every setting the picture was made with, so that it can be made again.
    pub settings: serde_json::Value,
    /// Which samples of what a render holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record: Option<Record>,
    /// Whether its counts only share samples out among buckets, for how many there are nobody knows.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub samples_unknown: bool,
}

impl StackHeader {
    /// What `stack`, which no film of ours made, is to us: as many sequences as buckets.
    pub fn of(stack: &FeatureStack, settings: serde_json::Value) -> Self {
        let buckets = stack.samples.dealing.buckets() as u32;
        let header = Self {
            first: stack.samples.first,
            sequences: buckets,
            buckets,
            per_bucket: None,
            settings,
            record: None,
            samples_unknown: false,
        };
        match &stack.samples.dealing {
            Dealing::Numbered { sequences, .. } => Self { sequences: *sequences, ..header },
            Dealing::PerPixel(_) => header,
            Dealing::PerBucket(counts) if counts.len() < 2 || is_even(counts, &stack.samples.total) => header,
            Dealing::PerBucket(counts) => Self { per_bucket: Some(counts.clone()), ..header },
        }
    }
}

/// Whether every bucket of every pixel holds equally many samples.
fn is_even(counts: &[u32], total: &[u32]) -> bool {
    let sum: u32 = counts.iter().sum();
    counts.iter().all(|n| *n == counts[0]) && total.iter().all(|n| *n == sum)
}

/// A named result to write beside the stack: one plane for each of `channels`.
#[derive(Clone, Copy, Debug)]
pub struct ResultLayer<'a> {
    /// Layer name; empty for the picture itself.
    pub name: &'a str,
    /// Channel names.
    pub channels: &'a [&'a str],
    /// One plane for each.
    pub planes: &'a [Vec<f32>],
}

/// Writes `results`, and with `with_inputs` all that a reconstruction starts from, to one EXR file, atomically, with what
/// is `carried` from the file the stack was read from.
///
/// # Errors
/// When the file cannot be written.
pub fn write_stack(
    path: &Path,
    stack: &FeatureStack,
    with_inputs: bool,
    header: &StackHeader,
    results: &[ResultLayer<'_>],
    carried: &Carried,
) -> Result<(), FileError> {
    let mut channels = Vec::new();
    for layer in results {
        for (channel, plane) in layer.channels.iter().zip(layer.planes) {
            channels.push((full_name(layer.name, channel), BorrowedSamples::Float(plane)));
        }
    }
    let counts = if with_inputs { count_planes(&stack.samples) } else { Vec::new() };
    if with_inputs {
        push_inputs(&mut channels, stack);
        channels.extend(counts.iter().map(|(name, plane)| (name.clone(), BorrowedSamples::Float(plane))));
    }
    channels.extend(stack.passthrough.iter().map(|c| (c.name.clone(), BorrowedSamples::Any(&c.samples))));
    let metadata = serde_json::to_value(header).ok();
    let frame = Frame { window: stack.window, film: stack.film, carried };
    write_channels(path, frame, metadata.as_ref(), channels)
}

/// Samples of every pixel, and those in each bucket where they do not follow from them.
fn count_planes(samples: &SampleCounts) -> Vec<(String, Vec<f32>)> {
    let plane = |counts: &Vec<u32>| counts.iter().map(|&n| n as f32).collect();
    let mut planes = vec![(full_name(SAMPLES, "Y"), plane(&samples.total))];
    if let Dealing::PerPixel(buckets) = &samples.dealing {
        let layer = |b| full_name(&bucket_layer(SAMPLES, b, buckets.len()), "Y");
        planes.extend(buckets.iter().enumerate().map(|(b, counts)| (layer(b), plane(counts))));
    }
    planes
}

type Channels<'a> = Vec<(String, BorrowedSamples<'a>)>;

fn push_inputs<'a>(channels: &mut Channels<'a>, stack: &'a FeatureStack) {
    for component in &stack.components {
        push_estimate(channels, component.role.layer(), &["R", "G", "B"], &component.radiance);
    }
    for (layer, light) in stack.parts_of_light() {
        push_estimate(channels, layer, &["R", "G", "B"], light);
    }
    for feature in &stack.features {
        push_estimate(channels, feature.role.layer(), feature.role.channels(), &feature.estimate);
    }
}

fn push_estimate<'a>(channels: &mut Channels<'a>, layer: &str, names: &[&str], estimate: &'a Estimate) {
    push_image(channels, layer, names, &estimate.mean);
    match &estimate.noise {
        Noise::Buckets(buckets) => {
            for (b, bucket) in buckets.iter().enumerate() {
                push_image(channels, &bucket_layer(layer, b, buckets.len()), names, bucket);
            }
        }
        Noise::VarianceOfMean(variance) => push_image(channels, &format!("{layer}Variance"), names, variance),
        Noise::Unknown => {}
    }
}

/// Layer of bucket `b` of `of`: two are the halves A and B.
pub(super) fn bucket_layer(layer: &str, b: usize, of: usize) -> String {
    match (of, b) {
        (2, 0) => format!("{layer}A"),
        (2, _) => format!("{layer}B"),
        _ => format!("{layer}.bucket{b}"),
    }
}

fn push_image<'a>(channels: &mut Channels<'a>, layer: &str, names: &[&str], image: &'a Image) {
    for (name, plane) in names.iter().zip(image.channels()) {
        channels.push((full_name(layer, name), BorrowedSamples::Float(plane)));
    }
}

fn full_name(layer: &str, channel: &str) -> String {
    if layer.is_empty() { channel.into() } else { format!("{layer}.{channel}") }
}

/// Layers of all that a reconstruction starts from.
pub(super) fn input_layers() -> impl Iterator<Item = &'static str> {
    let components = ComponentRole::ALL.map(ComponentRole::layer);
    components.into_iter().chain([INDIRECT, GATHERED]).chain(FeatureRole::ALL.map(FeatureRole::layer)).chain([SAMPLES])
}

/// Whether a file of ours may have a channel called `name` that is not carried along.
pub(super) fn may_write(name: &str) -> bool {
    let Some((layer, _)) = name.rsplit_once('.') else { return ["R", "G", "B"].contains(&name) };
    let is_estimate = |rest: &str| ["", "A", "B", "Variance"].contains(&rest) || rest.starts_with(".bucket");
    ["mse", "spikes", "bandwidth", "rank"].contains(&layer)
        || input_layers().any(|input| layer.strip_prefix(input).is_some_and(is_estimate))
}
