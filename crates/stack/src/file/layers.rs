//! An EXR file as a flat list of named channels.

use std::io::Write;
use std::path::{Path, PathBuf};

use exr::prelude::{AttributeValue, FlatSamples};

use super::borrowed::BorrowedSamples;
use super::exr_read::{Wanted, outline_exr, read_exr, understand};
use super::exr_text::encoded;
use super::exr_write::write_exr;
use super::header_order::sort_attributes;
use super::pfm::{is_pfm, outline_pfm, read_pfm_layers};
use super::{Action, Carried, FileError, write_atomically};
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
    /// Reads an EXR file, or a PFM or PHM file as channels `R G B` or `Y`.
    ///
    /// # Errors
    /// When the file is absent, a folder, damaged, or of a kind that is not supported (deep data, subsampled channels,
    /// parts of different size).
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::read_some(path, &|_| true)
    }

    /// The same of the channels whose names are `wanted`: the others take no memory.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_some(path: &Path, wanted: Wanted<'_>) -> Result<Self, FileError> {
        if !is_pfm_file(path)? {
            return read_exr(path, wanted);
        }
        let mut layers = read_pfm_layers(path)?;
        layers.channels.retain(|channel| wanted(&channel.name));
        Ok(layers)
    }

    /// The channels of such a file with one black pixel in place of the picture, and the picture's size: from its header
    /// alone.
    ///
    /// # Errors
    /// As [`Self::read`], where the header tells.
    pub(super) fn outline(path: &Path) -> Result<(Self, Size), FileError> {
        if is_pfm_file(path)? { outline_pfm(path) } else { outline_exr(path) }
    }

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

    /// Writes the channels as a one-part file, atomically, values as they are.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), FileError> {
        let channels = self.channels.iter().map(|c| (c.name.clone(), BorrowedSamples::Any(&c.samples))).collect();
        let frame = Frame { window: self.window, film: self.film, carried: &self.carried };
        write_channels(path, frame, self.metadata.as_ref(), channels)
    }
}

fn is_pfm_file(path: &Path) -> Result<bool, FileError> {
    if path.is_dir() {
        return Err(FileError::Folder { path: path.into() });
    }
    let mut start = [0; 3];
    let file = std::fs::File::open(path).map_err(|source| FileError::io(path, Action::Read, source))?;
    Ok(std::io::Read::read_exact(&mut &file, &mut start).is_ok() && is_pfm(&start))
}

/// What surrounds the channels of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<'a> {
    /// The pixels the channels cover.
    pub window: Window,
    /// Size of the display window.
    pub film: Size,
    /// Attributes to write again.
    pub carried: &'a Carried,
}

/// Writes named channels as a one-part file, atomically.
///
/// # Errors
/// When the file cannot be written.
pub(super) fn write_channels(
    path: &Path,
    frame: Frame<'_>,
    metadata: Option<&serde_json::Value>,
    channels: Vec<(String, BorrowedSamples<'_>)>,
) -> Result<(), FileError> {
    let (image_attributes, mut attributes, mut names) = frame.carried.for_file(frame.window, frame.film);
    if let Some(metadata) = metadata {
        let text = AttributeValue::Text(encoded(&metadata.to_string()));
        attributes.other.insert(encoded(METADATA), text);
        names.insert(METADATA.into());
    }
    let channels = channels.into_iter().map(|(name, samples)| (encoded(&name), samples)).collect();
    let size = (frame.window.size.width, frame.window.size.height);
    write_atomically(path, |out| {
        write_exr(&mut *out, size, (image_attributes, attributes), channels)
            .map_err(|error| understand(path, Action::Write, error))?;
        let failed = |source| FileError::io(path, Action::Write, source);
        out.flush().map_err(failed)?;
        sort_attributes(*out.get_mut(), &names).map_err(failed)
    })
}

/// Converts samples of any type to `f32` (without a copy when they are).
fn to_f32(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        FlatSamples::F16(values) => values.into_iter().map(|v| v.to_f32()).collect(),
        FlatSamples::U32(values) => values.into_iter().map(|v| v as f32).collect(),
    }
}
