//! Which image, and how it is laid on a surface.

use glam::{Mat2, Vec2};
use serde::Deserialize;

use crate::texture::Wrap;

/// Which image, and how it is laid on a surface.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) struct TextureUse {
    /// File name as written, blanks and all.
    pub(in super::super) file: String,
    /// What texture coordinates are multiplied with: how often the image repeats over one unit of them, and how it is turned.
    pub(in super::super) map: Mat2,
    /// What is added to that.
    pub(in super::super) offset: Vec2,
    /// What lies outside of the image, to the sides and above and below.
    pub(in super::super) wrap: [Wrap; 2],
    /// Which set of texture coordinates: 0, or 1 for the further one.
    pub(in super::super) set: u8,
    /// Of a height map, how many texels wide a height of 1 is high; of a normal map, a factor on its slopes.
    pub(in super::super) strength: f32,
    /// Which channel a single number is taken from, where it is said.
    pub(in super::super) channel: Option<Channel>,
}

/// Where a texture of single numbers takes them from.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Hash)]
#[serde(rename_all = "lowercase")]
pub(in super::super) enum Channel {
    Red,
    Green,
    Blue,
    Alpha,
    Luminance,
}

impl TextureUse {
    /// An image that covers texture coordinates 0 … 1 once, and repeats.
    pub(in super::super) const fn plain(file: String) -> Self {
        Self {
            file,
            map: Mat2::IDENTITY,
            offset: Vec2::ZERO,
            wrap: [Wrap::Repeat; 2],
            set: 0,
            strength: 1.0,
            channel: None,
        }
    }
}
