//! Images on surfaces, as files name them.

mod bump;
mod texture_files;
mod texture_use;

pub(super) use texture_files::TextureFiles;
pub(super) use texture_use::{Channel, TextureUse};
