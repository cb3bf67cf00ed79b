//! Decoding pictures.

use std::fs::File;
use std::io::{BufRead, Cursor, Read, Seek};
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageReader, Rgb32FImage, Rgba32FImage};
use stack::file::{extension, read_picture_with_alpha};

/// Decodes a picture, told apart by its content.
///
/// # Errors
/// In words, why it cannot be decoded.
pub(super) fn decode(file: &Path) -> Result<DynamicImage, String> {
    if extension(file) == "pfm" || starts_with(file, &OPEN_EXR) {
        return decode_floats(file);
    }
    let reader = ImageReader::open(file).and_then(ImageReader::with_guessed_format).map_err(|e| e.to_string())?;
    decode_all(reader, file.metadata().map_err(|e| e.to_string())?.len())
}

/// Decodes the bytes of a picture other than OpenEXR and PFM.
///
/// # Errors
/// In words, why they cannot be decoded.
pub(super) fn decode_bytes(bytes: &[u8]) -> Result<DynamicImage, String> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    decode_all(reader, bytes.len() as u64)
}

/// Decodes a picture of `length` bytes.
fn decode_all(reader: ImageReader<impl BufRead + Seek>, length: u64) -> Result<DynamicImage, String> {
    let decoder = reader.into_decoder().map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions();
    let bits = u64::from(width) * u64::from(height) * u64::from(decoder.original_color_type().bits_per_pixel());
    if bits / 8 > length.saturating_mul(MOST_COMPRESSED) {
        return Err(format!("its header claims {width}x{height} pixels, but it has {length} bytes"));
    }
    let image = DynamicImage::from_decoder(decoder).map_err(|e| e.to_string())?;
    if image.width() == 0 || image.height() == 0 { Err("it has no pixels".into()) } else { Ok(image) }
}

/// Bytes of pixels that one byte of a file can stand for: deflate reaches 1032, JPEG 1536 (blocks of 8 × 8 in a bit for
/// each of three colours).
const MOST_COMPRESSED: u64 = 1600;

/// How OpenEXR files begin.
const OPEN_EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

fn starts_with(file: &Path, start: &[u8; 4]) -> bool {
    let mut found = [0; 4];
    File::open(file).and_then(|mut file| file.read_exact(&mut found)).is_ok() && found == *start
}

/// Decodes OpenEXR and PFM.
fn decode_floats(file: &Path) -> Result<DynamicImage, String> {
    let (image, alpha) = read_picture_with_alpha(file).map_err(|error| error.to_string())?;
    let (size, rgb) = (image.size(), image.channels());
    let [width, height] = [size.width, size.height].map(|n| n as u32);
    let decoded = match alpha {
        None => {
            let values = (0..size.pixels()).flat_map(|p| [rgb[0][p], rgb[1][p], rgb[2][p]]).collect();
            Rgb32FImage::from_raw(width, height, values).map(DynamicImage::ImageRgb32F)
        }
        Some(alpha) => {
            let values = (0..size.pixels()).flat_map(|p| [rgb[0][p], rgb[1][p], rgb[2][p], alpha[p]]).collect();
            Rgba32FImage::from_raw(width, height, values).map(DynamicImage::ImageRgba32F)
        }
    };
    decoded.ok_or_else(|| "it has no pixels".into())
}

/// Width and height of a picture, and its pixels as linear RGB. Integers are taken as sRGB; floating point values are
/// linear already.
pub fn linear_rgb(image: &DynamicImage) -> ([usize; 2], Vec<[f32; 3]>) {
    let texels = match image {
        _ if is_linear(image) => image.to_rgb32f().pixels().map(|p| p.0).collect(),
        _ if image.color().bytes_per_pixel() / image.color().channel_count() == 1 => {
            let table: Vec<f32> = (0..=255u16).map(|i| srgb_to_linear(f32::from(i) / 255.0)).collect();
            image.to_rgb8().pixels().map(|p| p.0.map(|c| table[usize::from(c)])).collect()
        }
        _ => image.to_rgb32f().pixels().map(|p| p.0.map(srgb_to_linear)).collect(),
    };
    (size(image), texels)
}

/// Width and height, and pixels as they stand, without a transfer function: 0 … 1 where they are integers.
pub(super) fn plain_rgb(image: &DynamicImage) -> ([usize; 2], Vec<[f32; 3]>) {
    (size(image), image.to_rgb32f().pixels().map(|p| p.0).collect())
}

/// Width and height, and red, green, blue and alpha as they stand; alpha is 1 where there is none.
pub(super) fn plain_rgba(image: &DynamicImage) -> ([usize; 2], Vec<[f32; 4]>) {
    (size(image), image.to_rgba32f().pixels().map(|p| p.0).collect())
}

fn size(image: &DynamicImage) -> [usize; 2] {
    [image.width() as usize, image.height() as usize]
}

fn is_linear(image: &DynamicImage) -> bool {
    matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_))
}

/// The sRGB transfer function (IEC 61966-2-1), decoded.
pub(super) fn srgb_to_linear(c: f32) -> f32 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_that_claims_more_than_the_file_holds_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        image::GrayImage::new(3_000, 3_000).save(&path).unwrap();
        assert_eq!(decode(&path).unwrap().width(), 3_000, "zeros are compressed as far as can be");
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..2_000]).unwrap();
        assert!(decode(&path).unwrap_err().starts_with("its header claims 3000x3000 pixels"));
    }

    #[test]
    fn eight_bits_are_decoded_from_srgb() {
        let image = DynamicImage::ImageRgb8(image::RgbImage::from_raw(2, 1, vec![0, 255, 128, 10, 188, 1]).unwrap());
        let (_, texels) = linear_rgb(&image);
        // Table values of the standard's inverse: 128 → 0.21586, 188 → 0.50289, 10 → 0.0030353, 1 → 0.00030353.
        let expected = [[0.0, 1.0, 0.21586], [0.003_035_3, 0.502_89, 0.000_303_53]];
        for (texel, expected) in texels.iter().zip(expected) {
            for (a, b) in texel.iter().zip(expected) {
                assert!((a - b).abs() < 1e-5, "{a} is not {b}");
            }
        }
    }
}
