//! Reading images for textures.

use std::collections::HashMap;
use std::hash::Hash;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::DynamicImage;

use super::super::find_file::find_file;
use super::super::picture_file::{decode, decode_bytes, linear_rgb, plain_rgb, plain_rgba};
use super::bump::{is_normal_map, normals_of_heights, steeper};
use super::{Channel, TextureUse};
use crate::texture::{GreyTexture, Raster, Texel, Texture, Wrap};

/// Where an image lies on the surface: map, offset, what lies outside of it, and by which coordinates.
type Layout = ([u32; 6], [Wrap; 2], u8);

/// What has been made of which file, laid out how; the third number tells what was made of it.
type Made<K, T> = HashMap<(PathBuf, Layout, K), Arc<Raster<T>>>;

/// Reads images, and makes each texture once.
#[derive(Debug)]
pub(in super::super) struct TextureFiles<'a> {
    images: Images<'a>,
    colours: Made<(), [f32; 3]>,
    normals: Made<Relief, [f32; 3]>,
    greys: Made<Numbers, f32>,
}

/// Where images are.
#[derive(Debug)]
struct Images<'a> {
    folder: &'a Path,
    /// Files that are not on disk, by name.
    held: HashMap<String, Vec<u8>>,
    /// The last one that was decoded: roughness and metalness often share an image, and so do colour and opacity.
    last: Option<(PathBuf, DynamicImage)>,
}

impl Images<'_> {
    /// What tells the image that `name` means from others.
    fn key(&self, name: &str) -> Result<PathBuf, String> {
        if self.held.contains_key(name) {
            return Ok(name.into());
        }
        find_file(self.folder, name).ok_or_else(|| format!("texture '{name}' is missing"))
    }

    /// The image called `name` whose key is `file`.
    fn decoded(&mut self, name: &str, file: &Path) -> Result<&DynamicImage, String> {
        let image = match self.last.take() {
            Some((before, image)) if before == file => image,
            _ => self.held.get(name).map_or_else(|| decode(file), |bytes| decode_bytes(bytes))?,
        };
        Ok(&self.last.insert((file.into(), image)).1)
    }
}

/// How normals are read from an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Relief {
    /// As they stand, their slopes scaled by the number of these bits.
    Normals(u32),
    /// Heights, scaled by the number of these bits.
    Heights(u32),
}

/// How single numbers are read from an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Numbers {
    /// As they stand.
    Plain(Channel),
    /// Alpha, 1 where there is none.
    Alpha,
    /// As shares of the Phong exponent in these bits; the numbers are its roughness over that of the whole exponent.
    Exponents(Channel, u32),
    /// Alpha as shares of the gloss in these bits; the numbers are the roughness.
    Gloss(u32),
}

impl<'a> TextureFiles<'a> {
    /// Reads images named by files in `folder`.
    pub(in super::super) fn new(folder: &'a Path) -> Self {
        let images = Images { folder, held: HashMap::new(), last: None };
        Self { images, colours: HashMap::new(), normals: HashMap::new(), greys: HashMap::new() }
    }

    /// Takes the `bytes` of an image that is not on disk, unless it holds one of that name.
    ///
    /// # Errors
    /// When there are none.
    pub(in super::super) fn hold(
        &mut self,
        name: &str,
        bytes: impl FnOnce() -> Result<Vec<u8>, String>,
    ) -> Result<(), String> {
        if !self.images.held.contains_key(name) {
            self.images.held.insert(name.into(), bytes()?);
        }
        Ok(())
    }

    /// The colours of an image.
    ///
    /// # Errors
    /// In words, why there are none.
    pub(in super::super) fn colours(&mut self, texture: &TextureUse) -> Result<Arc<Texture>, String> {
        made(&mut self.images, texture, (), &mut self.colours, |image| Ok(linear_rgb(image)))
    }

    /// The normals of a normal map.
    ///
    /// # Errors
    /// In words, why there is none.
    pub(in super::super) fn normals(&mut self, texture: &TextureUse) -> Result<Arc<Texture>, String> {
        let relief = Relief::Normals(texture.strength.to_bits());
        made(&mut self.images, texture, relief, &mut self.normals, |image| {
            let (size, mut pixels) = plain_rgb(image);
            steeper(&mut pixels, texture.strength);
            Ok((size, pixels))
        })
    }

    /// Normals of the heights of an image; what looks like a normal map is taken for one.
    ///
    /// # Errors
    /// In words, why there are none.
    pub(in super::super) fn bumps(&mut self, texture: &TextureUse) -> Result<Arc<Texture>, String> {
        let relief = Relief::Heights(texture.strength.to_bits());
        made(&mut self.images, texture, relief, &mut self.normals, |image| {
            let (size, mut pixels) = plain_rgb(image);
            if is_normal_map(&pixels) {
                steeper(&mut pixels, texture.strength);
                return Ok((size, pixels));
            }
            let heights: Vec<f32> = image.to_luma32f().pixels().map(|p| p.0[0]).collect();
            Ok((size, normals_of_heights(size, &heights, texture.strength)))
        })
    }

    /// One number a pixel: of the channel that is asked for, else of `usual`; an image without alpha has luminance for it.
    ///
    /// # Errors
    /// In words, why there are none.
    pub(in super::super) fn greys(&mut self, texture: &TextureUse, usual: Channel) -> Result<Arc<GreyTexture>, String> {
        let channel = texture.channel.unwrap_or(usual);
        made(&mut self.images, texture, Numbers::Plain(channel), &mut self.greys, |image| {
            Ok(channel_of(image, channel))
        })
    }

    /// The alpha of an image, 1 where it has none.
    ///
    /// # Errors
    /// In words, why there is none.
    pub(in super::super) fn alphas(&mut self, texture: &TextureUse) -> Result<Arc<GreyTexture>, String> {
        made(&mut self.images, texture, Numbers::Alpha, &mut self.greys, |image| {
            let (size, pixels) = plain_rgba(image);
            Ok((size, pixels.into_iter().map(|[.., alpha]| alpha).collect()))
        })
    }

    /// Of an image whose alpha, 1 where it has none, is a share of the gloss `gloss`, the roughness, which is what is left to 1.
    ///
    /// # Errors
    /// In words, why there is none.
    pub(in super::super) fn roughness_of_gloss(
        &mut self,
        texture: &TextureUse,
        gloss: f32,
    ) -> Result<Arc<GreyTexture>, String> {
        made(&mut self.images, texture, Numbers::Gloss(gloss.to_bits()), &mut self.greys, |image| {
            let (size, pixels) = plain_rgba(image);
            Ok((size, pixels.into_iter().map(|[.., alpha]| 1.0 - gloss * alpha).collect()))
        })
    }

    /// Of an image of shares of the Phong exponent `exponent`, what the square root of `alpha(exponent)` is to be multiplied
    /// with.
    ///
    /// # Errors
    /// In words, why there is none.
    pub(in super::super) fn roughness_of_exponents(
        &mut self,
        texture: &TextureUse,
        exponent: f32,
        alpha: impl Fn(f32) -> f32,
    ) -> Result<Arc<GreyTexture>, String> {
        let channel = texture.channel.unwrap_or(Channel::Luminance);
        let kind = Numbers::Exponents(channel, exponent.to_bits());
        made(&mut self.images, texture, kind, &mut self.greys, |image| {
            let (size, shares) = channel_of(image, channel);
            let roughness = |share: f32| (alpha(share.max(0.0) * exponent) / alpha(exponent)).sqrt();
            Ok((size, shares.into_iter().map(roughness).collect()))
        })
    }
}

/// The texture `make` makes of the image that `texture` names, or the one it made before.
fn made<K: Copy + Eq + Hash, T: Texel>(
    images: &mut Images,
    texture: &TextureUse,
    kind: K,
    before: &mut Made<K, T>,
    make: impl FnOnce(&DynamicImage) -> Result<([usize; 2], Vec<T>), String>,
) -> Result<Arc<Raster<T>>, String> {
    let file = images.key(&texture.file)?;
    let ([a, b, c, d], [x, y]) = (texture.map.to_cols_array(), texture.offset.to_array());
    let layout = ([a, b, c, d, x, y].map(f32::to_bits), texture.wrap, texture.set);
    let key = (file.clone(), layout, kind);
    if let Some(texture) = before.get(&key) {
        return Ok(texture.clone());
    }
    let image = images.decoded(&texture.file, &file).and_then(make);
    let ([width, height], texels) = image.map_err(|e| format!("texture '{}' cannot be read: {e}", texture.file))?;
    let texture = Raster {
        map: texture.map,
        offset: texture.offset,
        wrap: texture.wrap,
        set: texture.set,
        ..Raster::new(width, height, texels)
    };
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
