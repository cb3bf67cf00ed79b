//! Writes a feature stack with whatever results belong to it.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::FileError;
use super::borrowed::BorrowedSamples;
use super::layers::write_channels;
use crate::{Estimate, FeatureStack, Image, Noise};

/// What a stack's file says about itself, beside its channels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StackHeader {
    /// Number of the first sample.
    pub first: u32,
    /// Independently scrambled sequences.
    pub sequences: u32,
    /// Buckets.
    pub buckets: u32,
    /// Every setting the picture was made with, so that it can be made again.
    pub settings: serde_json::Value,
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

/// Writes `results`, and with `stack` all that a reconstruction starts from, to one EXR file, atomically.
///
/// # Errors
/// When the file cannot be written.
pub fn write_stack(
    path: &Path,
    stack: &FeatureStack,
    with_inputs: bool,
    header: &StackHeader,
    results: &[ResultLayer<'_>],
) -> Result<(), FileError> {
    let mut channels = Vec::new();
    for layer in results {
        for (channel, plane) in layer.channels.iter().zip(layer.planes) {
            channels.push((full_name(layer.name, channel), BorrowedSamples::Float(plane)));
        }
    }
    let samples: Vec<f32> = stack.samples.total.iter().map(|&n| n as f32).collect();
    if with_inputs {
        push_inputs(&mut channels, stack);
        channels.push(("samples.Y".into(), BorrowedSamples::Float(&samples)));
    }
    channels.extend(stack.passthrough.iter().map(|c| (c.name.clone(), BorrowedSamples::Any(&c.samples))));
    let metadata = serde_json::to_value(header).ok();
    write_channels(path, stack.window, stack.film, metadata.as_ref(), channels)
}

type Channels<'a> = Vec<(String, BorrowedSamples<'a>)>;

fn push_inputs<'a>(channels: &mut Channels<'a>, stack: &'a FeatureStack) {
    for component in &stack.components {
        push_estimate(channels, component.role.layer(), &["R", "G", "B"], &component.radiance);
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
