//! `scene.toml`: geometry, cameras, lights, sky and changes to materials in one file. Every table has its own module.

mod camera_table;
mod document;
mod environment_table;
mod geometry_table;
mod image_table;
mod keys;
mod light_table;
mod material_table;
mod mistakes;
mod motion_table;
mod one_or_many;
mod render_table;
mod triple;
mod values;

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

pub use document::{TableDescription, describe_tables};
pub(super) use environment_table::SkyDescription;
pub(super) use geometry_table::{Geometry, Stand};
pub(super) use light_table::Light;
pub(super) use material_table::MaterialChange;
pub use mistakes::nearest as nearest_name;
pub use render_table::{RawRender, RenderEntry};

use super::SceneError;
use super::source::read_text;
use crate::camera::CameraDescription;
use camera_table::CameraTable;
use environment_table::EnvironmentTable;
use geometry_table::GeometryTable;
use light_table::LightTable;
use material_table::MaterialTable;
use mistakes::Lines;
use one_or_many::OneOrMany;

/// What a `scene.toml` says, checked.
#[derive(Debug, Default)]
pub(super) struct SceneDescription {
    pub(super) cameras: Vec<(Option<String>, CameraDescription)>,
    pub(super) environment: Option<SkyDescription>,
    pub(super) geometry: Vec<Geometry>,
    pub(super) lights: Vec<Light>,
    pub(super) material_changes: Vec<MaterialChange>,
    pub(super) render: Option<RawRender>,
}

/// The file as TOML has it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneTable {
    #[serde(default)]
    camera: OneOrMany<CameraTable>,
    environment: Option<EnvironmentTable>,
    #[serde(default)]
    geometry: OneOrMany<GeometryTable>,
    #[serde(default)]
    light: OneOrMany<LightTable>,
    #[serde(default)]
    material: BTreeMap<Spanned<String>, MaterialTable>,
    render: Option<BTreeMap<Spanned<String>, Spanned<toml::Value>>>,
}

/// Reads a `scene.toml`. Geometry files are named, not read.
///
/// # Errors
/// When the file cannot be read, is not TOML, has an unknown key or a value that cannot be.
pub(super) fn read_description(path: &Path) -> Result<SceneDescription, SceneError> {
    let text = read_text(path)?;
    let lines = Lines::new(&text, path);
    let table: SceneTable = toml::from_str(&text).map_err(|e| lines.mistake(&e))?;
    if table.geometry.0.is_empty() {
        return Err(lines.malformed(0, "at least one [[geometry]] table", "none"));
    }
    let cameras = table.camera.0.iter().map(|camera| camera.camera(&lines));
    let geometry = table.geometry.0.iter().map(|geometry| geometry.geometry(&lines));
    let lights = table.light.0.iter().map(|light| light.light(&lines));
    let changes = table.material.into_iter().map(|(name, table)| table.change(&name, &lines));
    Ok(SceneDescription {
        cameras: cameras.collect::<Result<_, _>>()?,
        environment: table.environment.map(|sky| sky.sky(&lines)).transpose()?,
        geometry: geometry.collect::<Result<_, _>>()?,
        lights: lights.collect::<Result<_, _>>()?,
        material_changes: changes.collect::<Result<_, _>>()?,
        render: table.render.map(|table| RawRender::new(path, &lines, &table)),
    })
}
