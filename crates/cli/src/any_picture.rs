//! Pictures of every format that can be read, as linear light.

use std::path::Path;

use anyhow::Result;
use image::{DynamicImage, ImageReader, Rgb32FImage};
use stack::file::{Action, FileError, Record, extension, read_picture_with_record};
use stack::{Image, Size};

use crate::exposure::decode_srgb;

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
    let decoded = decode(file)?;
    let is_linear = matches!(decoded, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let mut pixels = decoded.into_rgb32f();
    if !is_linear {
        pixels.iter_mut().for_each(|value| *value = decode_srgb(*value));
    }
    Ok((image_of(&pixels), Record::default()))
}

/// The values in `file`, as they are stored.
///
/// # Errors
/// When it cannot be read.
pub fn decode(file: &Path) -> Result<DynamicImage, FileError> {
    let io = |source| FileError::Io { path: file.into(), action: Action::Read, source };
    let reader = ImageReader::open(file).map_err(io)?.with_guessed_format().map_err(io)?;
    reader.decode().map_err(|error| {
        let reason = format!("{error}; expected .png, .exr, .pfm, .hdr, .jpg, .bmp or .tga");
        FileError::Damaged { path: file.into(), format: "picture", reason }
    })
}

/// The same values, channel by channel.
pub fn image_of(pixels: &Rgb32FImage) -> Image {
    let size = Size::new(pixels.width() as usize, pixels.height() as usize);
    Image::from_channels(size, (0..3).map(|c| pixels.pixels().map(|pixel| pixel.0[c]).collect()).collect())
}
