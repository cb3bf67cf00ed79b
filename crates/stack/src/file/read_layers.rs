//! The channels of a file, whatever its format.

use std::path::Path;

use super::exr_read::{Wanted, outline_exr, read_exr};
use super::pfm::{is_pfm, outline_pfm, read_pfm_layers};
use super::{Action, FileError, Layers};
use crate::Size;

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
}

fn is_pfm_file(path: &Path) -> Result<bool, FileError> {
    if path.is_dir() {
        return Err(FileError::Folder { path: path.into() });
    }
    let mut start = [0; 3];
    let file = std::fs::File::open(path).map_err(|source| FileError::io(path, Action::Read, source))?;
    Ok(std::io::Read::read_exact(&mut &file, &mut start).is_ok() && is_pfm(&start))
}
