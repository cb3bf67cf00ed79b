//! Reading images for textures.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::{DynamicImage, ImageReader};

use super::find_file;
use super::texture_line::TextureLine;
use crate::texture::Texture;

/// Reads images, each once.
#[derive(Debug)]
pub(super) struct TextureFiles<'a> {
    folder: &'a Path,
    read: HashMap<(PathBuf, [u32; 4]), Arc<Texture>>,
}

impl<'a> TextureFiles<'a> {
    /// Reads images named by files in `folder`.
    pub(super) fn new(folder: &'a Path) -> Self {
        Self { folder, read: HashMap::new() }
    }

    /// The texture a statement names.
    ///
    /// # Errors
    /// In words, why there is none.
    pub(super) fn get(&mut self, line: &TextureLine) -> Result<Arc<Texture>, String> {
        let file = find_file(self.folder, &line.file).ok_or_else(|| format!("texture '{}' is missing", line.file))?;
        let placement = [line.scale.x, line.scale.y, line.offset.x, line.offset.y].map(f32::to_bits);
        let key = (file.clone(), placement);
        if let Some(texture) = self.read.get(&key) {
            return Ok(texture.clone());
        }
        let image = decode(&file).map_err(|e| format!("texture '{}' cannot be read: {e}", line.file))?;
        let texture = Texture { scale: line.scale, offset: line.offset, ..linear(&image) };
        Ok(self.read.entry(key).or_insert(Arc::new(texture)).clone())
    }
}

fn decode(file: &Path) -> Result<DynamicImage, String> {
    let reader = ImageReader::open(file).and_then(ImageReader::with_guessed_format).map_err(|e| e.to_string())?;
    let image = reader.decode().map_err(|e| e.to_string())?;
    if image.width() == 0 || image.height() == 0 { Err("it has no pixels".into()) } else { Ok(image) }
}

/// Integers are taken as sRGB; floating point values are linear already.
fn linear(image: &DynamicImage) -> Texture {
    let is_linear = matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let texels = match image {
        _ if is_linear => image.to_rgb32f().pixels().map(|p| p.0).collect(),
        _ if image.color().bytes_per_pixel() / image.color().channel_count() == 1 => {
            let table: Vec<f32> = (0..=255u16).map(|i| srgb_to_linear(f32::from(i) / 255.0)).collect();
            image.to_rgb8().pixels().map(|p| p.0.map(|c| table[usize::from(c)])).collect()
        }
        _ => image.to_rgb32f().pixels().map(|p| p.0.map(srgb_to_linear)).collect(),
    };
    Texture::new(image.width() as usize, image.height() as usize, texels)
}

/// The sRGB transfer function (IEC 61966-2-1), decoded.
fn srgb_to_linear(c: f32) -> f32 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_bits_are_decoded_from_srgb() {
        let image = DynamicImage::ImageRgb8(image::RgbImage::from_raw(2, 1, vec![0, 255, 128, 10, 188, 1]).unwrap());
        let texture = linear(&image);
        // Table values of the standard's inverse: 128 → 0.21586, 188 → 0.50289, 10 → 0.0030353, 1 → 0.00030353.
        let expected = [[0.0, 1.0, 0.21586], [0.003_035_3, 0.502_89, 0.000_303_53]];
        for (texel, expected) in texture.texels.iter().zip(expected) {
            for (a, b) in texel.iter().zip(expected) {
                assert!((a - b).abs() < 1e-5, "{a} is not {b}");
            }
        }
    }
}
