//! Reading images for textures.

use std::collections::HashMap;
use std::hash::Hash;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::DynamicImage;

use super::super::picture_file::{decode, linear_rgb, plain_rgb, plain_rgba};
use super::bump::{is_normal_map, normals_of_heights};
use super::find_file;
use super::texture_line::{Channel, TextureLine};
use crate::texture::{GreyTexture, Raster, Texel, Texture};

/// Where an image lies on the surface: scale, offset, and whether it is clamped.
type Layout = ([u32; 4], bool);

/// What has been made of which file, laid out how; the third number tells what was made of it.
type Made<K, T> = HashMap<(PathBuf, Layout, K), Arc<Raster<T>>>;

/// Reads images, and makes each texture once.
#[derive(Debug)]
pub(super) struct TextureFiles<'a> {
    folder: &'a Path,
    colours: Made<(), [f32; 3]>,
    normals: Made<Relief, [f32; 3]>,
    greys: Made<Option<Channel>, f32>,
}

/// How normals are read from an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Relief {
    Normals,
    /// Heights, scaled by the number of these bits.
    Heights(u32),
}

impl<'a> TextureFiles<'a> {
    /// Reads images named by files in `folder`.
    pub(super) fn new(folder: &'a Path) -> Self {
        Self { folder, colours: HashMap::new(), normals: HashMap::new(), greys: HashMap::new() }
    }

    /// The colours of the image that a statement names.
    ///
    /// # Errors
    /// In words, why there are none.
    pub(super) fn colours(&mut self, line: &TextureLine) -> Result<Arc<Texture>, String> {
        made(self.folder, line, (), &mut self.colours, |image| Ok(linear_rgb(image)))
    }

    /// The normal map that a `norm` statement names.
    ///
    /// # Errors
    /// In words, why there is none.
    pub(super) fn normals(&mut self, line: &TextureLine) -> Result<Arc<Texture>, String> {
        made(self.folder, line, Relief::Normals, &mut self.normals, |image| Ok(plain_rgb(image)))
    }

    /// Normals of the heights that a `bump` statement names; what looks like a normal map is taken for one.
    ///
    /// # Errors
    /// In words, why there are none.
    pub(super) fn bumps(&mut self, line: &TextureLine) -> Result<Arc<Texture>, String> {
        let relief = Relief::Heights(line.bump.to_bits());
        made(self.folder, line, relief, &mut self.normals, |image| {
            let (size, pixels) = plain_rgb(image);
            if is_normal_map(&pixels) {
                return Ok((size, pixels));
            }
            let heights: Vec<f32> = image.to_luma32f().pixels().map(|p| p.0[0]).collect();
            Ok((size, normals_of_heights(size, &heights, line.bump)))
        })
    }

    /// One number a pixel: of the channel the statement names, else of `usual`; an image without alpha has luminance for
    /// it.
    ///
    /// # Errors
    /// In words, why there are none.
    pub(super) fn greys(&mut self, line: &TextureLine, usual: Channel) -> Result<Arc<GreyTexture>, String> {
        let channel = line.channel.unwrap_or(usual);
        made(self.folder, line, Some(channel), &mut self.greys, |image| Ok(channel_of(image, channel)))
    }
}

/// The texture `make` makes of the image that `line` names, or the one it made before.
fn made<K: Copy + Eq + Hash, T: Texel>(
    folder: &Path,
    line: &TextureLine,
    kind: K,
    before: &mut Made<K, T>,
    make: impl FnOnce(&DynamicImage) -> Result<([usize; 2], Vec<T>), String>,
) -> Result<Arc<Raster<T>>, String> {
    let file = find_file(folder, &line.file).ok_or_else(|| format!("texture '{}' is missing", line.file))?;
    let layout = ([line.scale.x, line.scale.y, line.offset.x, line.offset.y].map(f32::to_bits), line.clamp);
    let key = (file.clone(), layout, kind);
    if let Some(texture) = before.get(&key) {
        return Ok(texture.clone());
    }
    let image = decode(&file).and_then(|image| make(&image));
    let ([width, height], texels) = image.map_err(|e| format!("texture '{}' cannot be read: {e}", line.file))?;
    let texture =
        Raster { scale: line.scale, offset: line.offset, clamp: line.clamp, ..Raster::new(width, height, texels) };
    Ok(before.entry(key).or_insert(Arc::new(texture)).clone())
}

fn channel_of(image: &DynamicImage, channel: Channel) -> ([usize; 2], Vec<f32>) {
    let channel = if channel == Channel::Alpha && !image.color().has_alpha() { Channel::Luminance } else { channel };
    let (size, pixels) = plain_rgba(image);
    let number = |[r, g, b, a]: [f32; 4]| match channel {
        Channel::Red => r,
        Channel::Green => g,
        Channel::Blue => b,
        Channel::Alpha => a,
        Channel::Luminance => (r + g + b) / 3.0,
    };
    (size, pixels.into_iter().map(number).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_from_the_channel_asked_for() {
        let pixels = image::RgbaImage::from_raw(1, 1, vec![255, 51, 0, 102]).unwrap();
        let image = DynamicImage::ImageRgba8(pixels);
        for (channel, expected) in [
            (Channel::Red, 1.0),
            (Channel::Green, 0.2),
            (Channel::Blue, 0.0),
            (Channel::Alpha, 0.4),
            (Channel::Luminance, 0.4),
        ] {
            assert!((channel_of(&image, channel).1[0] - expected).abs() < 1e-6, "{channel:?}");
        }
        let opaque = DynamicImage::ImageLuma16(image::ImageBuffer::from_raw(1, 1, vec![0x8000_u16]).unwrap());
        assert!((channel_of(&opaque, Channel::Alpha).1[0] - 0.5).abs() < 1e-4);
    }
}
