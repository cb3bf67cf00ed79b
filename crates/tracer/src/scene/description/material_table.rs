//! `[material.NAME]`: changes to a material that a geometry file defines.

use glam::Vec3;
use serde::Deserialize;
use toml::Spanned;

use super::super::SceneError;
use super::super::error::Place;
use super::super::look::Look;
use super::mistakes::{Lines, nearest};
use crate::material::{Colour, Grey, Material, SurfaceMaps};

/// Changes to a material; what is left out stays as it is.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialTable {
    /// Colour of the diffuse base, of the metal, or tint of the glass; replaces a texture.
    base_color: Option<Spanned<Shade>>,
    /// 0 smooth … 1 rough; α is its square.
    roughness: Option<Spanned<f32>>,
    /// 0 or 1, or a mixture between.
    metallic: Option<Spanned<f32>>,
    /// 0 opaque, 1 clear glass.
    transmission: Option<Spanned<f32>>,
    /// Whether glass is a pane too thin to refract.
    thin: Option<bool>,
    /// Refractive index, of glass and of the coat.
    ior: Option<Spanned<f32>>,
    /// Share of rays that meet the surface; replaces a texture.
    alpha: Option<Spanned<f32>>,
    /// Emitted radiance.
    emission: Option<Spanned<Shade>>,
    /// Reflectance of the coat at normal incidence; 0 takes the coat off.
    specular: Option<Spanned<Shade>>,
}

/// A grey or a colour.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "expected a number or three numbers")]
enum Shade {
    Grey(f32),
    Colour([f32; 3]),
}

/// Changes to a material, checked.
#[derive(Debug)]
pub(in super::super) struct MaterialChange {
    name: String,
    place: Place,
    base_color: Option<Vec3>,
    roughness: Option<f32>,
    metallic: Option<f32>,
    transmission: Option<f32>,
    thin: Option<bool>,
    ior: Option<f32>,
    alpha: Option<f32>,
    emission: Option<Vec3>,
    specular: Option<Vec3>,
}

impl MaterialTable {
    /// The changes, checked.
    pub(super) fn change(&self, name: &Spanned<String>, lines: &Lines) -> Result<MaterialChange, SceneError> {
        let share = |value| number(value, 0.0..=1.0, "a number from 0 to 1", lines);
        Ok(MaterialChange {
            name: name.get_ref().clone(),
            place: lines.at(name.span().start),
            base_color: shade(&self.base_color, 1.0, "a reflectance from 0 to 1", lines)?,
            roughness: share(&self.roughness)?,
            metallic: share(&self.metallic)?,
            transmission: share(&self.transmission)?,
            thin: self.thin,
            alpha: share(&self.alpha)?,
            ior: number(&self.ior, 0.1..=10.0, "a refractive index from 0.1 to 10", lines)?,
            emission: shade(&self.emission, f32::MAX, "radiance of 0 or more", lines)?,
            specular: shade(&self.specular, 1.0, "a reflectance from 0 to 1", lines)?,
        })
    }
}

fn number(
    value: &Option<Spanned<f32>>,
    range: std::ops::RangeInclusive<f32>,
    expected: &str,
    lines: &Lines,
) -> Result<Option<f32>, SceneError> {
    let Some(value) = value else { return Ok(None) };
    let number = *value.get_ref();
    if range.contains(&number) {
        return Ok(Some(number));
    }
    Err(lines.malformed(value.span().start, expected, &number.to_string()))
}

fn shade(value: &Option<Spanned<Shade>>, most: f32, expected: &str, lines: &Lines) -> Result<Option<Vec3>, SceneError> {
    let Some(value) = value else { return Ok(None) };
    let colour = match *value.get_ref() {
        Shade::Grey(grey) => Vec3::splat(grey),
        Shade::Colour(colour) => Vec3::from_array(colour),
    };
    if colour.to_array().iter().all(|c| (0.0..=most).contains(c)) {
        return Ok(Some(colour));
    }
    Err(lines.malformed(value.span().start, expected, &colour.to_string()))
}

impl MaterialChange {
    /// Changes every material of that name.
    ///
    /// # Errors
    /// When there is none.
    pub(in super::super) fn apply(&self, materials: &mut [Material]) -> Result<(), SceneError> {
        if !materials.iter().any(|m| m.name == self.name) {
            let nearest = nearest(&self.name, materials.iter().map(|m| m.name.as_str()));
            let (place, name) = (self.place.clone(), self.name.clone());
            return Err(SceneError::UnknownName { place, what: "material", name, nearest });
        }
        materials.iter_mut().filter(|m| m.name == self.name).for_each(|m| self.change(m));
        Ok(())
    }

    fn change(&self, material: &mut Material) {
        if let Some(emission) = self.emission {
            material.emission = Colour::constant(emission);
        }
        let mut look = Look::of(&material.surface);
        if let Some(colour) = self.base_color {
            look.base = Colour::constant(colour);
        }
        if let Some(ior) = self.ior {
            look.set_ior(ior);
        }
        if let Some(specular) = self.specular {
            look.coat = Colour::constant(specular);
        }
        look.alpha = self.roughness.map(|r| r * r).or(look.alpha);
        look.metallic = self.metallic.unwrap_or(look.metallic);
        look.transmission = self.transmission.unwrap_or(look.transmission);
        look.thin = self.thin.unwrap_or(look.thin);
        self.change_maps(&mut material.maps);
        material.surface = look.surface();
    }

    /// Takes off the maps that a number replaces.
    fn change_maps(&self, maps: &mut SurfaceMaps) {
        if let Some(alpha) = self.alpha {
            maps.opacity = (alpha < 1.0).then_some(Grey::constant(alpha));
        }
        if self.roughness.is_some() {
            maps.roughness = None;
        }
        if self.metallic.is_some() {
            maps.metallic = None;
        }
    }
}
