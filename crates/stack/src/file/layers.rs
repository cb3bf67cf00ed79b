//! An EXR file as a flat list of named channels.

use std::path::PathBuf;

use exr::prelude::FlatSamples;

use super::Carried;
use crate::{Size, Window};

/// Name of the one text attribute that holds all our metadata.
pub(super) const METADATA: &str = "tamis";

/// A channel nobody here interprets, carried along with its name and its own number type.
#[derive(Clone, Debug, PartialEq)]
pub struct Passthrough {
    /// Full channel name, layers separated by dots.
    pub name: String,
    /// Values, row-major.
    pub samples: FlatSamples,
}

impl Passthrough {
    /// What its values take, in bytes.
    pub fn bytes(&self) -> usize {
        let each = match self.samples {
            FlatSamples::F16(_) => 2,
            FlatSamples::F32(_) | FlatSamples::U32(_) => 4,
        };
        each * self.samples.len()
    }

    /// The value at `pixel`, as `f32`.
    pub fn value(&self, pixel: usize) -> f32 {
        match &self.samples {
            FlatSamples::F32(values) => values[pixel],
            FlatSamples::F16(values) => values[pixel].to_f32(),
            FlatSamples::U32(values) => values[pixel] as f32,
        }
    }
}

/// All channels of an EXR file (of all its parts, when they cover the same window).
#[derive(Clone, Debug)]
pub struct Layers {
    /// Where it came from, for messages.
    pub path: PathBuf,
    /// The pixels the channels cover.
    pub window: Window,
    /// Size of the display window.
    pub film: Size,
    /// The channels.
    pub channels: Vec<Passthrough>,
    /// Our own metadata, when the file has any.
    pub metadata: Option<serde_json::Value>,
    /// What else it says, for the file that is made of it.
    pub carried: Carried,
}

impl Layers {
    /// Takes the channel called `name` out, as `f32`.
    pub fn take(&mut self, name: &str) -> Option<Vec<f32>> {
        let at = self.channels.iter().position(|channel| channel.name == name)?;
        Some(to_f32(self.channels.remove(at).samples))
    }

    /// Takes the channel called `name` out, and where it is the red of a scalar that is repeated in all three (LuxCore)
    /// its copies, too.
    pub(super) fn take_scalar(&mut self, name: &str) -> Option<Vec<f32>> {
        let plane = self.take(name)?;
        let copies = name.strip_suffix('R').map(|layer| ["G", "B"].map(|end| format!("{layer}{end}")));
        let is_copy = |channel: &Passthrough| {
            copies.as_ref().is_some_and(|copies| copies.contains(&channel.name))
                && (0..plane.len()).all(|pixel| channel.value(pixel).to_bits() == plane[pixel].to_bits())
        };
        self.channels.retain(|channel| !is_copy(channel));
        Some(plane)
    }

    /// Whether there is a channel called `name`.
    pub fn has(&self, name: &str) -> bool {
        self.channels.iter().any(|channel| channel.name == name)
    }

    /// Names of all channels, for messages.
    pub fn names(&self) -> String {
        self.channels.iter().map(|channel| channel.name.as_str()).collect::<Vec<_>>().join(" ")
    }
}

/// Converts samples of any type to `f32` (without a copy when they are).
fn to_f32(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        FlatSamples::F16(values) => values.into_iter().map(|v| v.to_f32()).collect(),
        FlatSamples::U32(values) => values.into_iter().map(|v| v as f32).collect(),
    }
}
