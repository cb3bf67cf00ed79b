//! Reading images for textures.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::super::picture_file::{decode, linear_rgb};
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
        let ([width, height], texels) = linear_rgb(&image);
        let texture = Texture { scale: line.scale, offset: line.offset, ..Texture::new(width, height, texels) };
        Ok(self.read.entry(key).or_insert(Arc::new(texture)).clone())
    }
}
