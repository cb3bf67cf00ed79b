//! `[environment]`.

use glam::Vec3;
use serde::Deserialize;
use toml::Spanned;

use super::super::SceneError;
use super::mistakes::Lines;

/// The sky: the same radiance from everywhere.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EnvironmentTable {
    /// Radiance; white when left out.
    color: Option<Spanned<[f32; 3]>>,
    /// Factor on top.
    scale: Option<Spanned<f32>>,
}

impl EnvironmentTable {
    /// The radiance, checked.
    pub(super) fn radiance(&self, lines: &Lines) -> Result<Vec3, SceneError> {
        let color = self.color.as_ref().map_or(Vec3::ONE, |c| Vec3::from_array(*c.get_ref()));
        let scale = self.scale.as_ref().map_or(1.0, |s| *s.get_ref());
        let radiance = color * scale;
        if radiance.is_finite() && radiance.min_element() >= 0.0 {
            return Ok(radiance);
        }
        let spans = [self.color.as_ref().map(Spanned::span), self.scale.as_ref().map(Spanned::span)];
        let offset = spans.into_iter().flatten().next().map_or(0, |span| span.start);
        Err(lines.malformed(offset, "radiance of 0 or more", &radiance.to_string()))
    }
}
