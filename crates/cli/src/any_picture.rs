//! Pictures of every format that can be read, as linear light.

use std::path::Path;

use anyhow::Result;
use image::ImageReader;
use stack::file::{Action, FileError, Record, extension, read_picture_with_record};
use stack::{Image, Size};
use tracer::scene::linear_rgb;

/// Formats that are read beside .exr, .pfm and .phm.
const ENDINGS: [&str; 6] = ["png", "hdr", "jpg", "jpeg", "bmp", "tga"];

/// Reads the picture in `file`, and what it says about how it was made. What has bytes for colours is taken for sRGB.
///
/// # Errors
/// When it cannot be read, or holds no colour.
pub fn read_any_picture(file: &Path) -> Result<(Image, Record)> {
    if !ENDINGS.contains(&extension(file).as_str()) {
        return Ok(read_picture_with_record(file)?);
    }
    Ok((decode(file)?, Record::default()))
}

/// The picture in `file`, in any format but .exr and .pfm.
///
/// # Errors
/// When it cannot be read.
pub fn decode(file: &Path) -> Result<Image, FileError> {
    let io = |source| FileError::Io { path: file.into(), action: Action::Read, source };
    let reader = ImageReader::open(file).map_err(io)?.with_guessed_format().map_err(io)?;
    let decoded = reader.decode().map_err(|error| {
        let reason = format!("{error}; expected .png, .exr, .pfm, .hdr, .jpg, .bmp or .tga");
        FileError::Damaged { path: file.into(), format: "picture", reason }
    })?;
    let ([width, height], pixels) = linear_rgb(&decoded);
    let plane = |c: usize| pixels.iter().map(|pixel| pixel[c]).collect();
    Ok(Image::from_channels(Size::new(width, height), (0..3).map(plane).collect()))
}
