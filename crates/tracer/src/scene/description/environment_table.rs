//! `[environment]`.

use std::path::PathBuf;

use glam::Vec3;

use super::super::SceneError;
use super::keys::{FINITE, NOT_NEGATIVE, TomlTable, toml_table};
use super::mistakes::Lines;
use super::triple::Triple;

toml_table! {
    /// The sky: the same radiance from everywhere, or a latitude-longitude map.
    pub(super) struct EnvironmentTable {
        /// Radiance HDR, OpenEXR (DWA included), PFM; or any picture that textures may be
        optional file: PathBuf = "none";
        /// radiance; not together with `file`
        default color: Triple = Triple::splat(1.0), NOT_NEGATIVE;
        /// turns the map round +*y*, in degrees, counter-clockwise seen from above
        default rotate: f32 = 0.0, FINITE;
        /// factor on top
        default scale: f32 = 1.0, NOT_NEGATIVE;
    }
}

/// A sky, checked.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) enum SkyDescription {
    /// The same radiance everywhere.
    Constant(Vec3),
    /// A map, not read yet.
    Map {
        /// Relative to the scene file.
        file: PathBuf,
        /// In degrees.
        rotate: f32,
        /// Factor on its radiance.
        scale: f32,
    },
}

impl EnvironmentTable {
    /// The sky, checked.
    pub(super) fn sky(&self, lines: &Lines) -> Result<SkyDescription, SceneError> {
        self.check(lines)?;
        let Some(file) = self.file() else {
            return Ok(SkyDescription::Constant(self.color().vec3() * self.scale()));
        };
        if let Some(color) = self.place_of("color") {
            return Err(lines.malformed(color, "either file or color", "both"));
        }
        Ok(SkyDescription::Map { file: file.clone(), rotate: self.rotate(), scale: self.scale() })
    }
}
