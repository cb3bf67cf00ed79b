//! A plain picture: three channels of linear radiance.

use std::path::Path;

use super::borrowed::BorrowedSamples;
use super::layers::{Frame, write_channels};
use super::{Carried, FileError, Layers, read_pfm, write_pfm};
use crate::{Image, Window};

/// Reads the picture in an EXR file (its `R G B`, or the first layer that has them) or a PFM file.
///
/// # Errors
/// When the file cannot be read or holds no colour.
pub fn read_picture(path: &Path) -> Result<Image, FileError> {
    if extension(path) == "pfm" {
        return read_pfm(path);
    }
    let mut layers = Layers::read(path)?;
    let prefix = colour_prefix(&layers)?;
    let planes = ["R", "G", "B"].iter().filter_map(|c| layers.take(&format!("{prefix}{c}"))).collect();
    Ok(Image::from_channels(layers.window.size, planes))
}

/// What stands in front of `R`, `G` and `B` in the channels that hold the picture.
pub(super) fn colour_prefix(layers: &Layers) -> Result<String, FileError> {
    let complete = |prefix: &str| ["R", "G", "B"].iter().all(|c| layers.has(&format!("{prefix}{c}")));
    let nested = || {
        let reds = layers.channels.iter().filter_map(|channel| channel.name.strip_suffix(".R"));
        let beauty = |layer: &&str| {
            let own = layer.rsplit('.').next().unwrap_or(layer).to_lowercase();
            ["combined", "noisy image", "noisy", "beauty", "rgba"].contains(&own.as_str())
        };
        reds.filter(beauty).map(|layer| format!("{layer}.")).find(|prefix| complete(prefix))
    };
    if complete("") { Some(String::new()) } else { nested() }.ok_or_else(|| FileError::Missing {
        path: layers.path.clone(),
        wanted: "colour",
        expected: "R G B".into(),
        found: layers.names(),
    })
}

/// Writes `image` as an EXR or, by its ending, a PFM file.
///
/// # Errors
/// When the file cannot be written.
pub fn write_picture(path: &Path, image: &Image) -> Result<(), FileError> {
    if extension(path) == "pfm" {
        return write_pfm(path, image);
    }
    let channels = ["R", "G", "B"].iter().zip(image.channels());
    let channels = channels.map(|(name, plane)| ((*name).to_string(), BorrowedSamples::Float(plane))).collect();
    let frame = Frame { window: Window::whole(image.size()), film: image.size(), carried: &Carried::default() };
    write_channels(path, frame, None, channels)
}

/// The file's ending in lower case, without its dot; empty when there is none.
pub fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Size;

    #[test]
    fn a_picture_survives_a_round_trip_and_a_cut_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let planes = (0..3).map(|c| (0..12).map(|i| (c * 7 + i) as f32 * 0.3).collect()).collect();
        let image = Image::from_channels(Size::new(4, 3), planes);
        write_picture(&path, &image).unwrap();
        assert_eq!(read_picture(&path).unwrap(), image);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        assert!(matches!(read_picture(&path), Err(FileError::Damaged { .. })));
        assert!(matches!(read_picture(folder.path()), Err(FileError::Folder { .. })));
        assert!(matches!(read_picture(&folder.path().join("b.exr")), Err(FileError::Io { .. })));
    }
}
