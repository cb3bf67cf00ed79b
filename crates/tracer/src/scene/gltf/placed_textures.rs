//! Textures as a glTF file lays them on surfaces.

use glam::{Mat2, Vec2};
use gltf::json;
use gltf::material::NormalTexture;
use gltf::texture::{Info, Texture, TextureTransform, WrappingMode};
use serde::{Deserialize, Deserializer};

use super::super::textures::{TextureFiles, TextureUse};
use super::buffers::{Buffers, embedded, file_name};
use crate::texture::Wrap;

/// A texture and how it is laid out.
#[derive(Clone)]
pub(super) struct PlacedTexture<'a> {
    texture: Texture<'a>,
    /// Which texture coordinates.
    pub(super) set: u32,
    map: Mat2,
    offset: Vec2,
}

impl<'a> PlacedTexture<'a> {
    /// A texture that covers its coordinates once.
    fn plain(texture: Texture<'a>, set: u32) -> Self {
        Self { texture, set, map: Mat2::IDENTITY, offset: Vec2::ZERO }
    }

    /// What `normals` says, and its `KHR_texture_transform`, which the crate leaves unread there.
    ///
    /// # Errors
    /// In words, why that cannot be read.
    pub(super) fn of_normals(normals: &NormalTexture<'a>) -> Result<Self, String> {
        let plain = Self::plain(normals.texture(), normals.tex_coord());
        plain.moved_as_written(normals.extension_value("KHR_texture_transform"))
    }

    /// A texture that an extension of materials names, which the crate does not know.
    ///
    /// # Errors
    /// In words, when there is no such texture.
    pub(super) fn of_extension(written: &json::texture::Info, document: &'a gltf::Document) -> Result<Self, String> {
        let plain = Self::plain(numbered(written.index.value(), document)?, written.tex_coord);
        let transform = written.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref());
        Ok(transform.map_or(plain.clone(), |transform| plain.moved(transform)))
    }

    /// The same of a normal map.
    ///
    /// # Errors
    /// In words, when there is no such texture, or the transform cannot be read.
    pub(super) fn of_normals_of_extension(
        written: &json::material::NormalTexture,
        document: &'a gltf::Document,
    ) -> Result<Self, String> {
        let plain = Self::plain(numbered(written.index.value(), document)?, written.tex_coord);
        let others = written.extensions.as_ref().map(|extensions| &extensions.others);
        plain.moved_as_written(others.and_then(|others| others.get("KHR_texture_transform")))
    }

    /// Moved as a `KHR_texture_transform` says that the crate has left as it is written.
    fn moved_as_written<'w, W: Deserializer<'w>>(self, written: Option<W>) -> Result<Self, String> {
        let Some(written) = written else { return Ok(self) };
        let transform = json::extensions::texture::TextureTransform::deserialize(written);
        let transform = transform.map_err(|why| format!("KHR_texture_transform of its normal texture: {why}"))?;
        Ok(self.moved(&transform))
    }

    fn moved(self, transform: &json::extensions::texture::TextureTransform) -> Self {
        self.laid_out(upwards(transform.scale.0, transform.rotation.0, transform.offset.0), transform.tex_coord)
    }

    /// What `info` says.
    pub(super) fn of(info: &Info<'a>) -> Self {
        let plain = Self::plain(info.texture(), info.tex_coord());
        match info.texture_transform() {
            Some(transform) => plain.transformed(&transform),
            None => plain,
        }
    }

    fn transformed(self, transform: &TextureTransform) -> Self {
        self.laid_out(upwards(transform.scale(), transform.rotation(), transform.offset()), transform.tex_coord())
    }

    /// Laid out by `map` and `offset`, and by another set of coordinates where one is named.
    fn laid_out(self, (map, offset): (Mat2, Vec2), set: Option<u32>) -> Self {
        Self { set: set.unwrap_or(self.set), map, offset, ..self }
    }

    /// The image, for `files` to read; one that lies in the file itself is given to them.
    ///
    /// # Errors
    /// In words, why there is none.
    pub(super) fn texture_use(
        &self,
        document: &gltf::Document,
        buffers: &Buffers,
        files: &mut TextureFiles,
    ) -> Result<TextureUse, String> {
        let number = self.texture.index();
        let Some(image) = self.texture.source() else {
            return Err(format!("textures[{number}] has no PNG or JPEG image"));
        };
        let inside = format!("images[{}]", image.index());
        // As it is written: the crate expects more of it than it checks.
        let written = &document.as_json().images[image.index()];
        let view = written.buffer_view.and_then(|view| document.views().nth(view.value()));
        let file = match (view, written.uri.as_deref()) {
            (Some(view), _) => {
                files.hold(&inside, || buffers.view(&view).map(<[u8]>::to_vec))?;
                inside
            }
            (None, Some(uri)) => match embedded(uri) {
                Some(bytes) => {
                    files.hold(&inside, || bytes.map_err(|why| format!("texture '{inside}' {why}")))?;
                    inside
                }
                None => file_name(uri),
            },
            (None, None) => return Err(format!("texture '{inside}' is nowhere")),
        };
        let sampler = self.texture.sampler();
        let wrap = [sampler.wrap_s(), sampler.wrap_t()].map(|mode| match mode {
            WrappingMode::Repeat => Wrap::Repeat,
            WrappingMode::ClampToEdge => Wrap::Clamp,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
        });
        Ok(TextureUse { map: self.map, offset: self.offset, wrap, ..TextureUse::plain(file) })
    }
}

fn numbered(number: usize, document: &gltf::Document) -> Result<Texture<'_>, String> {
    document.textures().nth(number).ok_or_else(|| format!("textures[{number}] is not there"))
}

/// The map of `KHR_texture_transform`, of texture coordinates that begin at the bottom of an image instead of at its top:
/// scaled, turned counterclockwise as one sees the image, moved.
fn upwards(scale: [f32; 2], rotation: f32, offset: [f32; 2]) -> (Mat2, Vec2) {
    let (sin, cos) = rotation.sin_cos();
    let turned = Mat2::from_cols_array(&[cos, -sin, sin, cos]) * Mat2::from_diagonal(scale.into());
    let flip = Mat2::from_diagonal(Vec2::new(1.0, -1.0));
    (flip * turned * flip, flip * (turned * Vec2::Y + Vec2::from(offset)) + Vec2::Y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_moved_as_if_they_began_at_the_top() {
        let (map, offset) = upwards([2.0, 0.5], 0.3, [0.1, 0.7]);
        for from in [Vec2::new(0.2, 0.9), Vec2::new(0.7, 0.1)] {
            let (s, c) = 0.3_f32.sin_cos();
            let scaled = Vec2::new(2.0, 0.5) * from;
            let expected = Vec2::new(c * scaled.x + s * scaled.y + 0.1, c * scaled.y - s * scaled.x + 0.7);
            let flipped = |v: Vec2| Vec2::new(v.x, 1.0 - v.y);
            assert!((flipped(map * flipped(from) + offset) - expected).length() < 1e-5);
        }
    }
}
