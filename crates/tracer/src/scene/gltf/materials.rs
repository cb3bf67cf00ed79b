//! Materials of a glTF file: base colour, metalness, roughness, and what extensions add.

use std::cell::Cell;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use gltf::json;
use gltf::material::AlphaMode;
use serde::Deserialize;

use super::super::look::{COMMON_COAT, Look, metalness};
use super::super::notes::Notes;
use super::super::textures::{Channel, TextureFiles, TextureUse};
use super::buffers::Buffers;
use super::placed_textures::PlacedTexture;
use crate::material::{ClearCoat, Colour, Grey, Material, SeeThrough, Surface, SurfaceMaps, Tinted};
use crate::texture::{GreyTexture, Texture};

/// What meshes have to know of a material.
#[derive(Clone, Copy, Debug)]
pub(super) struct Needs {
    /// Which texture coordinates it is laid out by; the same twice where it needs no others.
    pub(super) sets: [u32; 2],
    /// What the opacity of vertices is for.
    pub(super) alpha: AlphaMode,
}

/// The materials of `document`, and what meshes have to know of each. The last two are for primitives that have none: first for
/// those whose vertices have no colours, then for those whose have. Textures that are not there are left out and noted.
pub(super) fn read_materials(
    document: &gltf::Document,
    buffers: &Buffers,
    folder: &Path,
    notes: &mut Notes,
) -> (Vec<Material>, Vec<Needs>) {
    let mut reader = Reader { document, buffers, files: TextureFiles::new(folder), notes, ignored: Vec::new() };
    let (mut materials, mut needs) = (Vec::new(), Vec::new());
    for material in document.materials() {
        let name = material.name().map_or_else(|| format!("material {}", materials.len()), str::to_owned);
        let (set, further) = (set_of(&material), Cell::new(None));
        materials.push(reader.material(One { material: &material, name, set, further: &further }));
        needs.push(Needs { sets: [set, further.get().unwrap_or(set)], alpha: material.alpha_mode() });
    }
    reader.note_ignored();
    // What the specification gives them is rough white metal; viewers and their users know dull grey.
    for reflectance in [0.5, 1.0] {
        let dull = Surface::Diffuse { reflectance: Colour::constant(Vec3::splat(reflectance)) };
        materials.push(Material::new("no material", dull, Vec3::ZERO));
        needs.push(Needs { sets: [0; 2], alpha: AlphaMode::Opaque });
    }
    (materials, needs)
}

/// The texture coordinates of the first texture that there is.
fn set_of(material: &gltf::Material) -> u32 {
    let pbr = material.pbr_metallic_roughness();
    let infos = [pbr.base_color_texture(), pbr.metallic_roughness_texture(), material.emissive_texture()];
    let placed = infos.into_iter().flatten().next().map(|info| PlacedTexture::of(&info).set);
    let of_normals = || PlacedTexture::of_normals(&material.normal_texture()?).ok();
    placed.or_else(|| of_normals().map(|placed| placed.set)).unwrap_or(0)
}

/// What a volume takes of light by unit length; nothing where it does not say.
fn absorption(volume: &gltf::material::Volume) -> Vec3 {
    let distance = volume.attenuation_distance();
    // Even what is black lets a little pass, so that no way is too short to be black.
    let left = Vec3::from(volume.attenuation_color()).clamp(Vec3::splat(BLACKEST), Vec3::ONE);
    if distance > 0.0 { -left.map(f32::ln) / distance } else { Vec3::ZERO }
}

/// Least share of light that is left at the distance that a volume's colour is for.
const BLACKEST: f32 = 1e-6;

/// `KHR_materials_clearcoat` of a material.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct WrittenClearCoat {
    clearcoat_factor: f32,
    clearcoat_texture: Option<json::texture::Info>,
    clearcoat_roughness_factor: f32,
    clearcoat_roughness_texture: Option<json::texture::Info>,
    clearcoat_normal_texture: Option<json::material::NormalTexture>,
}

/// `KHR_materials_pbrSpecularGlossiness` of a material.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct WrittenGlossiness {
    diffuse_factor: [f32; 4],
    diffuse_texture: Option<json::texture::Info>,
    specular_factor: [f32; 3],
    glossiness_factor: f32,
    specular_glossiness_texture: Option<json::texture::Info>,
}

impl Default for WrittenGlossiness {
    fn default() -> Self {
        Self {
            diffuse_factor: [1.0; 4],
            diffuse_texture: None,
            specular_factor: [1.0; 3],
            glossiness_factor: 1.0,
            specular_glossiness_texture: None,
        }
    }
}

struct Reader<'a> {
    document: &'a gltf::Document,
    buffers: &'a Buffers,
    files: TextureFiles<'a>,
    notes: &'a mut Notes,
    /// What is not supported, and the names of the materials that have it.
    ignored: Vec<(&'static str, Vec<String>)>,
}

/// A material that is being read.
struct One<'a> {
    material: &'a gltf::Material<'a>,
    name: String,
    /// The texture coordinates that it is laid out by.
    set: u32,
    /// Others that a part of its textures is laid out by, once one has been met.
    further: &'a Cell<Option<u32>>,
}

impl<'a> Reader<'a> {
    fn material(&mut self, one: One) -> Material {
        if let Some(written) = self.glossiness(&one) {
            return self.glossy_material(one, &written);
        }
        let pbr = one.material.pbr_metallic_roughness();
        let [red, green, blue, alpha] = pbr.base_color_factor();
        let base_texture = pbr.base_color_texture().map(|info| PlacedTexture::of(&info));
        let base = self.colour(&one, Vec3::new(red, green, blue), base_texture.clone());
        let emission = self.emission(&one);
        let mut maps = SurfaceMaps::default();
        (maps.opacity, maps.cutoff) = self.opacity(&one, alpha, base_texture);
        maps.normals = self.normals(&one);
        if one.material.unlit() {
            let black = Surface::Diffuse { reflectance: Colour::constant(Vec3::ZERO) };
            maps.tinted = Tinted::Emission;
            return Material { name: one.name, surface: black, emission: base, maps };
        }
        let parts = pbr.metallic_roughness_texture().map(|info| PlacedTexture::of(&info));
        let parts = parts.and_then(|placed| self.place(&one, &placed));
        let mut metallic = Grey::constant(pbr.metallic_factor());
        if let Some(texture) = &parts {
            maps.roughness = self.found(&one, |files| files.greys(texture, Channel::Green));
            let map = self.found(&one, |files| files.greys(texture, Channel::Blue));
            // A map of nothing but ones or zeros is a number.
            match map.as_ref().and_then(|map| map.constant()) {
                Some(number) => metallic.factor *= number,
                None => metallic.texture = map,
            }
        }
        let metal;
        (metal, maps.metallic) = metalness(metallic);
        let roughness = pbr.roughness_factor();
        let look = self.look(&one, base, metal, roughness * roughness);
        maps.specular = self.specular_map(&one);
        maps.clear_coat = self.clear_coat(&one);
        // Light does not pass through metal.
        let Some(share) = self.transmission(&one).filter(|_| !metal) else {
            let surface = look.surface(maps.metallic.is_some());
            return Material { name: one.name, surface, emission, maps };
        };
        let glass = self.glass(&one, &look, &emission, &maps);
        if share.texture.is_none() && share.factor >= 1.0 && maps.metallic.is_none() {
            return glass;
        }
        let surface = look.surface(maps.metallic.is_some());
        maps.see_through = Some(Box::new(SeeThrough { share, glass }));
        Material { name: one.name, surface, emission, maps }
    }

    /// `KHR_materials_pbrSpecularGlossiness`, which older files have in place of metal and roughness.
    fn glossiness(&mut self, one: &One) -> Option<WrittenGlossiness> {
        let written = one.material.extension_value("KHR_materials_pbrSpecularGlossiness")?;
        self.found(one, |_| {
            WrittenGlossiness::deserialize(written).map_err(|why| format!("KHR_materials_pbrSpecularGlossiness: {why}"))
        })
    }

    fn glossy_material(&mut self, one: One, written: &WrittenGlossiness) -> Material {
        let [diffuse, specular] = [&written.diffuse_texture, &written.specular_glossiness_texture]
            .map(|info| self.placed_by_extension(&one, info.as_ref()?));
        let [red, green, blue, alpha] = written.diffuse_factor;
        let base = self.colour(&one, Vec3::new(red, green, blue), diffuse.clone());
        let coat = self.colour(&one, Vec3::from(written.specular_factor), specular.clone());
        let mut maps = SurfaceMaps::default();
        (maps.opacity, maps.cutoff) = self.opacity(&one, alpha, diffuse);
        maps.normals = self.normals(&one);
        let gloss = written.glossiness_factor.clamp(0.0, 1.0);
        let texture = specular.and_then(|placed| self.place(&one, &placed));
        maps.roughness =
            texture.and_then(|texture| self.found(&one, |files| files.roughness_of_gloss(&texture, gloss)));
        let roughness = if maps.roughness.is_some() { 1.0 } else { 1.0 - gloss };
        let look = Look {
            base,
            coat: Some(coat),
            alpha: Some(roughness * roughness),
            metal: false,
            transmission: 0.0,
            thin: false,
            ior: 1.5,
        };
        let emission = self.emission(&one);
        Material { name: one.name, surface: look.surface(false), emission, maps }
    }

    fn look(&mut self, one: &One, base: Colour, metal: bool, alpha: f32) -> Look {
        let mut look = Look { base, coat: None, alpha: Some(alpha), metal, transmission: 0.0, thin: false, ior: 1.5 };
        if let Some(ior) = one.material.ior().filter(|ior| *ior >= 1.0) {
            look.set_ior(ior);
        }
        if let Some(specular) = one.material.specular() {
            let factor = specular.specular_factor() * Vec3::from(specular.specular_color_factor());
            let coat = look.coat.map_or(Vec3::splat(COMMON_COAT), |coat| coat.factor);
            let placed = specular.specular_color_texture().map(|info| PlacedTexture::of(&info));
            look.coat = Some(self.colour(one, (coat * factor).clamp(Vec3::ZERO, Vec3::ONE), placed));
        }
        look
    }

    fn specular_map(&mut self, one: &One) -> Option<Arc<GreyTexture>> {
        let placed = PlacedTexture::of(&one.material.specular()?.specular_texture()?);
        let texture = self.place(one, &placed)?;
        self.found(one, |files| files.greys(&texture, Channel::Alpha))
    }

    /// Share of the light that passes of what is not reflected, where any does.
    fn transmission(&mut self, one: &One) -> Option<Grey> {
        let transmission = one.material.transmission().filter(|t| t.transmission_factor() > 0.0)?;
        let placed = transmission.transmission_texture().map(|info| PlacedTexture::of(&info));
        let texture = placed.and_then(|placed| self.place(one, &placed));
        let texture = texture.and_then(|texture| self.found(one, |files| files.greys(&texture, Channel::Red)));
        Some(Grey { factor: transmission.transmission_factor().min(1.0), texture })
    }

    /// What a material of that look is where light passes.
    fn glass(&mut self, one: &One, look: &Look, emission: &Colour, maps: &SurfaceMaps) -> Material {
        if maps.clear_coat.is_some() {
            self.ignore(one, "a clear coat over glass is");
        }
        // Without a volume behind it, a surface is a pane.
        let volume = one.material.volume().filter(|volume| volume.thickness_factor() > 0.0);
        let look = Look { transmission: 1.0, thin: volume.is_none(), ..look.clone() };
        let mut maps = maps.clone();
        (maps.clear_coat, maps.metallic, maps.specular) = (None, None, None);
        maps.absorption = volume.map_or(Vec3::ZERO, |volume| absorption(&volume));
        Material { name: one.name.clone(), surface: look.surface(false), emission: emission.clone(), maps }
    }

    /// `KHR_materials_clearcoat`, which the crate leaves unread.
    fn clear_coat(&mut self, one: &One) -> Option<ClearCoat> {
        let written = one.material.extension_value("KHR_materials_clearcoat")?;
        let written = self.found(one, |_| {
            WrittenClearCoat::deserialize(written).map_err(|why| format!("KHR_materials_clearcoat: {why}"))
        })?;
        if written.clearcoat_factor.is_nan() || written.clearcoat_factor <= 0.0 {
            return None;
        }
        let mut number = |factor: f32, texture: Option<&json::texture::Info>, channel| {
            let placed = texture.and_then(|info| self.placed_by_extension(one, info));
            let texture = placed.and_then(|placed| self.place(one, &placed));
            let texture = texture.and_then(|texture| self.found(one, |files| files.greys(&texture, channel)));
            Grey { factor: factor.clamp(0.0, 1.0), texture }
        };
        let cover = number(written.clearcoat_factor, written.clearcoat_texture.as_ref(), Channel::Red);
        let roughness = written.clearcoat_roughness_texture.as_ref();
        let roughness = number(written.clearcoat_roughness_factor, roughness, Channel::Green);
        let document = self.document;
        let normals = written.clearcoat_normal_texture.and_then(|normals| {
            let placed = self.found(one, |_| PlacedTexture::of_normals_of_extension(&normals, document))?;
            self.relief(one, &placed, normals.scale)
        });
        Some(ClearCoat { cover, roughness, normals })
    }

    fn placed_by_extension(&mut self, one: &One, info: &json::texture::Info) -> Option<PlacedTexture<'a>> {
        let document = self.document;
        self.found(one, |_| PlacedTexture::of_extension(info, document))
    }

    fn colour(&mut self, one: &One, factor: Vec3, placed: Option<PlacedTexture>) -> Colour {
        let texture = placed.and_then(|placed| self.place(one, &placed));
        let texture = texture.and_then(|texture| self.found(one, |files| files.colours(&texture)));
        Colour { factor, texture }
    }

    fn emission(&mut self, one: &One) -> Colour {
        let strength = one.material.emissive_strength().unwrap_or(1.0);
        let factor = strength * Vec3::from(one.material.emissive_factor());
        let placed = one.material.emissive_texture().filter(|_| factor != Vec3::ZERO);
        self.colour(one, factor, placed.map(|info| PlacedTexture::of(&info)))
    }

    /// What share of it is there, and from which opacity on all is; the first is `None` where it is opaque.
    fn opacity(&mut self, one: &One, factor: f32, placed: Option<PlacedTexture>) -> (Option<Grey>, Option<f32>) {
        let cutoff = match one.material.alpha_mode() {
            AlphaMode::Opaque => return (None, None),
            AlphaMode::Blend => None,
            AlphaMode::Mask => Some(one.material.alpha_cutoff().unwrap_or(0.5)),
        };
        let texture = placed.and_then(|placed| self.place(one, &placed));
        let texture = texture.and_then(|texture| self.found(one, |files| files.alphas(&texture)));
        // An image of the same alpha everywhere is a number.
        let opacity = match texture.as_ref().and_then(|texture| texture.constant()) {
            Some(alpha) => Grey::constant(factor * alpha),
            None => Grey { factor, texture },
        };
        (Some(opacity), cutoff)
    }

    fn normals(&mut self, one: &One) -> Option<Arc<Texture>> {
        let normal = one.material.normal_texture()?;
        let placed = self.found(one, |_| PlacedTexture::of_normals(&normal))?;
        self.relief(one, &placed, normal.scale())
    }

    fn relief(&mut self, one: &One, placed: &PlacedTexture, strength: f32) -> Option<Arc<Texture>> {
        let texture = self.place(one, placed)?;
        let texture = TextureUse { strength, ..texture };
        self.found(one, |files| files.normals(&texture))
    }

    /// The image of a texture, if there is one that the mesh has coordinates for.
    fn place(&mut self, one: &One, placed: &PlacedTexture) -> Option<TextureUse> {
        // Meshes keep two sets.
        let is_further = placed.set != one.set;
        if is_further && one.further.get().is_some_and(|further| further != placed.set) {
            self.ignore(one, "textures laid out by a third set of texture coordinates are");
            return None;
        }
        let texture = placed.texture_use(self.document, self.buffers, &mut self.files);
        let texture = self.found(one, |_| texture)?;
        if is_further {
            one.further.set(Some(placed.set));
        }
        Some(TextureUse { set: u8::from(is_further), ..texture })
    }

    fn found<T>(&mut self, one: &One, find: impl FnOnce(&mut TextureFiles) -> Result<T, String>) -> Option<T> {
        let found = find(&mut self.files);
        found
            .map_err(|why| self.notes.add_missing_texture(format!("material '{}': {why}; it is left out", one.name)))
            .ok()
    }

    fn ignore(&mut self, one: &One, what: &'static str) {
        match self.ignored.iter_mut().find(|(other, _)| *other == what) {
            Some((_, names)) if names.contains(&one.name) => {}
            Some((_, names)) => names.push(one.name.clone()),
            None => self.ignored.push((what, vec![one.name.clone()])),
        }
    }

    /// One line for each kind.
    fn note_ignored(&mut self) {
        for (what, names) in &self.ignored {
            let others = match names.len() - 1 {
                0 => String::new(),
                1 => " and 1 other".into(),
                others => format!(" and {others} others"),
            };
            self.notes.add(format!("material '{}'{others}: {what} not supported and ignored", names[0]));
        }
    }
}
