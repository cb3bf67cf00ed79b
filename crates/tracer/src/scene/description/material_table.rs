//! `[material.NAME]`: changes to a material that a geometry file defines.

use std::sync::Arc;

use glam::Vec3;
use toml::Spanned;

use super::super::SceneError;
use super::super::error::Place;
use super::super::look::{Look, metalness};
use super::super::textures::{Channel, TextureFiles, TextureUse};
use super::image_table::ImageTable;
use super::keys::{NOT_NEGATIVE, SHARE, TomlTable, toml_table};
use super::mistakes::{Lines, nearest};
use super::triple::Triple;
use super::values::{Image, Textured};
use crate::material::{ClearCoat, Colour, Grey, Material};
use crate::texture::Texture;

toml_table! {
    /// Changes to a material; what is left out stays as it is.
    pub(super) struct MaterialTable {
        /// diffuse colour, colour of the metal, or tint of the glass
        optional base_color: Textured<Triple> = "as in the file", SHARE;
        /// α is its square; on a plain diffuse surface it brings a coat of reflectance 0.04
        optional roughness: Textured<f32> = "as in the file", SHARE;
        /// 1 is a metal; between, so much of it is a metal of the base's colour
        optional metallic: Textured<f32> = "as in the file", SHARE;
        /// from 0.5 on glass, rough where the material is rough; else opaque
        optional transmission: f32 = "as in the file", SHARE;
        /// glass is a pane too thin to refract, frosted where the material is rough
        optional thin: bool = "as in the file";
        /// share of rays that meet the surface, the others pass through
        optional alpha: Textured<f32> = "as in the file", SHARE;
        /// refractive index; also sets the coat to ((n − 1)/(n + 1))²
        optional ior: f32 = "as in the file", 0.1..=10.0;
        /// reflectance of the coat at normal incidence; overrides `ior`; 0 takes the coat off
        optional specular: Textured<Triple> = "as in the file", SHARE;
        /// share of the surface that is below a clear coat of reflectance 0.04; glass has none
        optional clear_coat: Textured<f32> = "as in the file", SHARE;
        /// roughness of the clear coat, 0 where nobody says; α is its square
        optional clear_coat_roughness: Textured<f32> = "as in the file", SHARE;
        /// emitted radiance
        optional emission: Textured<Triple> = "as in the file", NOT_NEGATIVE;
        /// normals in the frame of *u* and *v* (OpenGL's convention)
        optional normal_map: Image = "as in the file";
        /// heights; one of 1 is as high as a texel is wide, times `factor`; not together with `normal_map`
        optional bump_map: Image = "as in the file";
    }
}

/// Changes to a material, checked; images are named, not read.
#[derive(Debug)]
pub(in super::super) struct MaterialChange {
    name: String,
    place: Place,
    base_color: Option<ColourChange>,
    roughness: Option<NumberChange>,
    metallic: Option<NumberChange>,
    transmission: Option<f32>,
    thin: Option<bool>,
    ior: Option<f32>,
    alpha: Option<NumberChange>,
    clear_coat: Option<NumberChange>,
    clear_coat_roughness: Option<NumberChange>,
    emission: Option<ColourChange>,
    specular: Option<ColourChange>,
    relief: Option<(Relief, Located)>,
}

/// A texture and where in the file it is asked for.
#[derive(Debug)]
struct Located {
    place: Place,
    texture: TextureUse,
}

/// A constant, and the texture it is multiplied with.
#[derive(Debug)]
struct Change<T> {
    factor: T,
    texture: Option<Located>,
}

type ColourChange = Change<Vec3>;
type NumberChange = Change<f32>;

/// What an image of relief holds.
#[derive(Clone, Copy, Debug)]
enum Relief {
    Normals,
    Heights,
}

impl MaterialTable {
    /// The changes, checked.
    pub(super) fn change(&self, name: &Spanned<String>, lines: &Lines) -> Result<MaterialChange, SceneError> {
        self.check(lines)?;
        Ok(MaterialChange {
            name: name.get_ref().clone(),
            place: lines.at(name.span().start),
            base_color: colour(&self.base_color, lines)?,
            roughness: number(&self.roughness, lines)?,
            metallic: number(&self.metallic, lines)?,
            transmission: self.transmission().copied(),
            thin: self.thin().copied(),
            alpha: number(&self.alpha, lines)?,
            clear_coat: number(&self.clear_coat, lines)?,
            clear_coat_roughness: number(&self.clear_coat_roughness, lines)?,
            ior: self.ior().copied(),
            emission: colour(&self.emission, lines)?,
            specular: colour(&self.specular, lines)?,
            relief: self.relief(lines)?,
        })
    }

    fn relief(&self, lines: &Lines) -> Result<Option<(Relief, Located)>, SceneError> {
        let (kind, image) = match (&self.normal_map, &self.bump_map) {
            (Some(_), Some(both)) => {
                return Err(lines.malformed(both.span().start, "either normal_map or bump_map", "both"));
            }
            (Some(image), None) => (Relief::Normals, image),
            (None, Some(image)) => (Relief::Heights, image),
            (None, None) => return Ok(None),
        };
        let at = image.span().start;
        one_number(&image.get_ref().0, at, lines)?;
        Ok(Some((kind, located(&image.get_ref().0, at, lines)?)))
    }
}

fn colour(given: &Option<Spanned<Textured<Triple>>>, lines: &Lines) -> Result<Option<ColourChange>, SceneError> {
    let Some(given) = given else { return Ok(None) };
    Ok(Some(match given.get_ref() {
        Textured::Value(value) => Change { factor: value.vec3(), texture: None },
        Textured::Image(image) => {
            let texture = located(image, given.span().start, lines)?;
            Change { factor: image.factor().vec3(), texture: Some(texture) }
        }
    }))
}

fn number(given: &Option<Spanned<Textured<f32>>>, lines: &Lines) -> Result<Option<NumberChange>, SceneError> {
    let Some(given) = given else { return Ok(None) };
    Ok(Some(match given.get_ref() {
        Textured::Value(factor) => Change { factor: *factor, texture: None },
        Textured::Image(image) => {
            let texture = located(image, given.span().start, lines)?;
            Change { factor: one_number(image, given.span().start, lines)?, texture: Some(texture) }
        }
    }))
}

/// The factor of an image that is no colour.
fn one_number(image: &ImageTable, offset: usize, lines: &Lines) -> Result<f32, SceneError> {
    let wrong = || lines.malformed(image.place_of("factor").unwrap_or(offset), "one number for factor", "three");
    image.factor().one().ok_or_else(wrong)
}

fn located(image: &ImageTable, offset: usize, lines: &Lines) -> Result<Located, SceneError> {
    image.check(lines)?;
    Ok(Located { place: lines.at(offset), texture: image.texture_use() })
}

impl MaterialChange {
    /// Changes every material of that name, with images from `files`.
    ///
    /// # Errors
    /// When there is none, or an image cannot be read.
    pub(in super::super) fn apply(
        &self,
        materials: &mut [Material],
        files: &mut TextureFiles,
    ) -> Result<(), SceneError> {
        if !materials.iter().any(|m| m.name == self.name) {
            let nearest = nearest(&self.name, materials.iter().map(|m| m.name.as_str()));
            let (place, name) = (self.place.clone(), self.name.clone());
            return Err(SceneError::UnknownName { place, what: "material".into(), name, nearest });
        }
        materials.iter_mut().filter(|m| m.name == self.name).try_for_each(|m| self.change(m, files))
    }

    fn change(&self, material: &mut Material, files: &mut TextureFiles) -> Result<(), SceneError> {
        // What was said of a share is no more where it is said of the whole.
        material.maps.see_through.take_if(|_| self.transmission.is_some());
        if let Some(see_through) = &mut material.maps.see_through {
            self.change(&mut see_through.glass, files)?;
        }
        let mut look = Look::of(&material.surface);
        if let Some(change) = &self.base_color {
            look.base = change.read(files)?;
        }
        if let Some(ior) = self.ior {
            look.set_ior(ior);
        }
        if let Some(change) = &self.specular {
            look.coat = Some(change.read(files)?);
            material.maps.specular = None;
        }
        if let Some(change) = &self.emission {
            material.emission = change.read(files)?;
        }
        look.transmission = self.transmission.unwrap_or(look.transmission);
        look.thin = self.thin.unwrap_or(look.thin);
        self.change_numbers(&mut look, material, files)?;
        self.change_clear_coat(material, files)?;
        if let Some((kind, image)) = &self.relief {
            material.maps.normals = Some(read_relief(*kind, image, files)?);
        }
        material.surface = look.surface(material.maps.metallic.is_some());
        Ok(())
    }

    /// Roughness, metalness and opacity: numbers take off the maps that were there, maps bring numbers to multiply with.
    fn change_numbers(
        &self,
        look: &mut Look,
        material: &mut Material,
        files: &mut TextureFiles,
    ) -> Result<(), SceneError> {
        let maps = &mut material.maps;
        if let Some(change) = &self.roughness {
            look.alpha = Some(change.factor * change.factor);
            maps.roughness = change.read(files, Channel::Luminance)?.texture;
        }
        if let Some(change) = &self.metallic {
            (look.metal, maps.metallic) = metalness(change.read(files, Channel::Luminance)?);
        }
        if let Some(change) = &self.alpha {
            let opacity = change.read(files, Channel::Alpha)?;
            maps.cutoff = None;
            maps.opacity = (opacity.texture.is_some() || opacity.factor < 1.0).then_some(opacity);
        }
        Ok(())
    }
}

impl MaterialChange {
    /// A coat that covers nothing is none.
    fn change_clear_coat(&self, material: &mut Material, files: &mut TextureFiles) -> Result<(), SceneError> {
        let mut coat = material.maps.clear_coat.take().unwrap_or(ClearCoat::even(0.0, 0.0));
        if let Some(change) = &self.clear_coat {
            coat.cover = change.read(files, Channel::Luminance)?;
        }
        if let Some(change) = &self.clear_coat_roughness {
            coat.roughness = change.read(files, Channel::Luminance)?;
        }
        material.maps.clear_coat = (coat.cover.factor > 0.0).then_some(coat);
        Ok(())
    }
}

impl ColourChange {
    fn read(&self, files: &mut TextureFiles) -> Result<Colour, SceneError> {
        let read = |image: &Located| files.colours(&image.texture).map_err(|reason| image.refused(reason));
        Ok(Colour { factor: self.factor, texture: self.texture.as_ref().map(read).transpose()? })
    }
}

impl NumberChange {
    fn read(&self, files: &mut TextureFiles, usual: Channel) -> Result<Grey, SceneError> {
        let read = |image: &Located| files.greys(&image.texture, usual).map_err(|reason| image.refused(reason));
        Ok(Grey { factor: self.factor, texture: self.texture.as_ref().map(read).transpose()? })
    }
}

fn read_relief(kind: Relief, image: &Located, files: &mut TextureFiles) -> Result<Arc<Texture>, SceneError> {
    let read = match kind {
        Relief::Normals => files.normals(&image.texture),
        Relief::Heights => files.bumps(&image.texture),
    };
    read.map_err(|reason| image.refused(reason))
}

impl Located {
    fn refused(&self, reason: String) -> SceneError {
        SceneError::BadTexture { place: self.place.clone(), reason }
    }
}
