//! `[environment]`.

use std::path::PathBuf;

use glam::Vec3;
use serde::Deserialize;
use toml::Spanned;

use super::super::SceneError;
use super::mistakes::Lines;

/// The sky: the same radiance from everywhere, or a latitude-longitude map.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EnvironmentTable {
    /// A map, relative to the scene file.
    file: Option<Spanned<PathBuf>>,
    /// Radiance, where there is no map; white when left out.
    color: Option<Spanned<[f32; 3]>>,
    /// The map's turn round +y in degrees, counter-clockwise seen from above.
    rotate: Option<Spanned<f32>>,
    /// Factor on top.
    scale: Option<Spanned<f32>>,
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
        let scale = self.scale.as_ref().map_or(1.0, |s| *s.get_ref());
        match (&self.file, &self.color) {
            (None, _) => self.constant(scale, lines).map(SkyDescription::Constant),
            (Some(_), Some(color)) => Err(lines.malformed(color.span().start, "either file or color", "both")),
            (Some(file), None) => self.map(file.get_ref().clone(), scale, lines),
        }
    }

    fn constant(&self, scale: f32, lines: &Lines) -> Result<Vec3, SceneError> {
        let color = self.color.as_ref().map_or(Vec3::ONE, |c| Vec3::from_array(*c.get_ref()));
        let radiance = color * scale;
        if radiance.is_finite() && radiance.min_element() >= 0.0 {
            return Ok(radiance);
        }
        let spans = [self.color.as_ref().map(Spanned::span), self.scale.as_ref().map(Spanned::span)];
        let offset = spans.into_iter().flatten().next().map_or(0, |span| span.start);
        Err(lines.malformed(offset, "radiance of 0 or more", &radiance.to_string()))
    }

    fn map(&self, file: PathBuf, scale: f32, lines: &Lines) -> Result<SkyDescription, SceneError> {
        let rotate = self.rotate.as_ref().map_or(0.0, |r| *r.get_ref());
        let at = |spanned: &Option<Spanned<f32>>| spanned.as_ref().map_or(0, |s| s.span().start);
        if !rotate.is_finite() {
            return Err(lines.malformed(at(&self.rotate), "an angle in degrees", &rotate.to_string()));
        }
        if !(scale >= 0.0 && scale.is_finite()) {
            return Err(lines.malformed(at(&self.scale), "a factor of 0 or more", &scale.to_string()));
        }
        Ok(SkyDescription::Map { file, rotate, scale })
    }
}
