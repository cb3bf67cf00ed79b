//! Named channels as a file.

use std::io::Write;
use std::path::Path;

use exr::prelude::AttributeValue;

use super::borrowed::BorrowedSamples;
use super::exr_read::understand;
use super::exr_text::encoded;
use super::exr_write::write_exr;
use super::header_order::sort_attributes;
use super::layers::METADATA;
use super::{Action, Carried, FileError, Layers, write_atomically};
use crate::{Size, Window};

impl Layers {
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
