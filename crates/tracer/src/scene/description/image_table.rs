//! An image on a surface: `"file.png"`, or a table.

use std::path::PathBuf;

use glam::{Mat2, Vec2};
use serde::Deserialize;
use toml::Spanned;

use super::super::textures::{Channel, TextureUse};
use super::keys::{FINITE, NOT_NEGATIVE, TomlValue, toml_table};
use super::triple::Triple;
use crate::texture::Wrap;

toml_table! {
    /// An image on a surface.
    pub(super) struct ImageTable {
        /// PNG, JPEG, TGA, BMP, HDR or EXR, relative to the scene file
        required file: PathBuf;
        /// multiplied with what the image says; of a normal or bump map, how much steeper it makes it
        default factor: Triple = Triple::splat(1.0), NOT_NEGATIVE;
        /// how often the image repeats over one unit of *u* and *v*
        default scale: [f32; 2] = [1.0, 1.0], FINITE;
        /// added to the scaled *u* and *v*
        default offset: [f32; 2] = [0.0, 0.0], FINITE;
        /// what lies outside of 0 … 1: the image again, its border, or the image every other time turned round
        default wrap: Outside = Outside::Repeat;
        /// where a single number is taken from
        optional channel: Channel = "`alpha` for `alpha`, where the image has it; else `luminance`";
    }
}

/// What lies outside of an image.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum Outside {
    Repeat,
    Clamp,
    Mirror,
}

impl Outside {
    const fn wrap(self) -> Wrap {
        match self {
            Self::Repeat => Wrap::Repeat,
            Self::Clamp => Wrap::Clamp,
            Self::Mirror => Wrap::Mirror,
        }
    }
}

impl TomlValue for Outside {
    fn kind() -> String {
        "`\"repeat\"`, `\"clamp\"` or `\"mirror\"`".into()
    }

    fn written(&self) -> String {
        let name = match self {
            Self::Repeat => "repeat",
            Self::Clamp => "clamp",
            Self::Mirror => "mirror",
        };
        format!("`\"{name}\"`")
    }
}

impl TomlValue for Channel {
    fn kind() -> String {
        "`\"red\"`, `\"green\"`, `\"blue\"`, `\"alpha\"` or `\"luminance\"`".into()
    }
}

impl ImageTable {
    /// The image in `file`, without more ado.
    pub(super) fn plain(file: &str) -> Self {
        let file = Spanned::new(0..0, file.into());
        Self { file, factor: None, scale: None, offset: None, wrap: None, channel: None }
    }

    /// Which image, and how it is laid.
    pub(super) fn texture_use(&self) -> TextureUse {
        TextureUse {
            file: self.file().to_string_lossy().into_owned(),
            map: Mat2::from_diagonal(self.scale().into()),
            offset: Vec2::from_array(self.offset()),
            wrap: [self.wrap().wrap(); 2],
            set: 0,
            strength: self.factor().0[0] as f32,
            channel: self.channel().copied(),
        }
    }
}
