//! The maps of an MTL entry beside its colours.

use std::sync::Arc;

use super::super::look::metalness;
use super::super::notes::Notes;
use super::super::textures::{Channel, TextureFiles, TextureUse};
use super::convert::alpha_of_phong;
use super::entry::MtlEntry;
use crate::material::{ClearCoat, Grey, SurfaceMaps};
use crate::texture::{GreyTexture, Texture};

impl MtlEntry {
    /// The maps; without their textures when there is nobody to read them. What cannot be read is noted.
    pub(super) fn maps(&self, mut read: Option<(&mut TextureFiles, &mut Notes)>) -> SurfaceMaps {
        let mut grey = |line: &Option<TextureUse>, usual| {
            let (line, (files, notes)) = (line.as_ref()?, read.as_mut()?);
            self.found(files.greys(line, usual), notes)
        };
        let holes = grey(&self.opacity_map, Channel::Alpha);
        let roughness = grey(&self.roughness_map, Channel::Luminance);
        let metallic = grey(&self.metallic_map, Channel::Luminance);
        let shininess = match (&roughness, &mut read) {
            (None, Some((files, notes))) => self.shininess_map(files, notes),
            _ => None,
        };
        let normals = read.and_then(|(files, notes)| self.normals(files, notes));
        let opacity = self.opacity_factor();
        let mut maps = SurfaceMaps::default();
        maps.opacity = (holes.is_some() || opacity < 1.0).then_some(Grey { factor: opacity, texture: holes });
        maps.normals = normals;
        maps.roughness = roughness.or(shininess);
        maps.metallic = self.metalness(metallic);
        maps.clear_coat = self.clear_coat();
        maps
    }

    /// `map_Ns`, where it counts: in front of it an `Ns`, and no `Pr` beside it.
    fn shininess_map(&self, files: &mut TextureFiles, notes: &mut Notes) -> Option<Arc<GreyTexture>> {
        let line = self.shininess_map.as_ref().filter(|_| self.roughness.is_none())?;
        let Some(exponent) = self.shininess.filter(|&ns| ns > 0.0) else {
            notes.add(format!("material '{}': map_Ns without Ns is ignored", self.name));
            return None;
        };
        self.found(files.roughness_of_exponents(line, exponent, alpha_of_phong), notes)
    }

    /// `norm`, else `bump`.
    fn normals(&self, files: &mut TextureFiles, notes: &mut Notes) -> Option<Arc<Texture>> {
        match (&self.normal_map, &self.bump_map) {
            (Some(line), _) => self.found(files.normals(line), notes),
            (None, Some(line)) => self.found(files.bumps(line), notes),
            (None, None) => None,
        }
    }

    fn found<T>(&self, texture: Result<T, String>, notes: &mut Notes) -> Option<T> {
        texture
            .map_err(|why| notes.add_missing_texture(format!("material '{}': {why}; it is left out", self.name)))
            .ok()
    }

    /// `d` of what is no glass. Zero is a habit of exporters, not a wish to see nothing.
    fn opacity_factor(&self) -> f32 {
        self.opacity.filter(|&d| d > 0.0 && !self.is_glass()).map_or(1.0, |d| d.min(1.0))
    }

    /// `Pc` and `Pcr`; none on glass, which has a surface like that already.
    fn clear_coat(&self) -> Option<ClearCoat> {
        let cover = self.clear_coat.filter(|&pc| pc > 0.0 && !self.is_glass())?;
        let roughness = self.clear_coat_roughness.unwrap_or(0.0).clamp(0.0, 1.0);
        Some(ClearCoat::even(cover.min(1.0), roughness))
    }

    /// `Pm`, times `map` where there is one; `None` where nothing or all of it is metal. A zero in front of a texture is a habit
    /// of exporters.
    fn metalness(&self, map: Option<Arc<GreyTexture>>) -> Option<Grey> {
        let said = self.metallic.filter(|&pm| pm > 0.0).map(|pm| pm.min(1.0));
        let factor = said.or(map.is_some().then_some(1.0))?;
        metalness(Grey { factor, texture: map }).1
    }
}
