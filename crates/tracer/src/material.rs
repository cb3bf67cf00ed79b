//! What a surface is made of, as data: loaders fill it in, `bsdf` turns it into scattering at a point.

use std::sync::{Arc, OnceLock};

use glam::Vec3;

use crate::bsdf::{GlassAlbedo, MetalAlbedo, SharedTables, Table};
use crate::texture::{GreyTexture, TexCoords, Texture};

/// A colour that may vary over the surface: a constant, times a texture when there is one. Linear RGB.
#[derive(Clone, Debug)]
pub struct Colour {
    /// The constant.
    pub factor: Vec3,
    /// Multiplied with the constant.
    pub texture: Option<Arc<Texture>>,
}

impl Colour {
    /// The same colour everywhere.
    pub const fn constant(factor: Vec3) -> Self {
        Self { factor, texture: None }
    }

    /// The colour at texture coordinates `uv`.
    #[inline]
    pub fn at(&self, uv: impl Into<TexCoords>) -> Vec3 {
        self.factor * self.texture.as_ref().map_or(Vec3::ONE, |texture| texture.lookup(uv))
    }

    /// Its mean over the texture.
    pub fn mean(&self) -> Vec3 {
        self.factor * self.texture.as_ref().map_or(Vec3::ONE, |texture| texture.mean())
    }
}

/// A number that may vary over the surface: a constant, times a texture when there is one.
#[derive(Clone, Debug)]
pub struct Grey {
    /// The constant.
    pub factor: f32,
    /// Multiplied with the constant.
    pub texture: Option<Arc<GreyTexture>>,
}

impl Grey {
    /// The same number everywhere.
    pub const fn constant(factor: f32) -> Self {
        Self { factor, texture: None }
    }

    /// The number at texture coordinates `uv`.
    #[inline]
    pub fn at(&self, uv: impl Into<TexCoords>) -> f32 {
        self.factor * self.texture.as_ref().map_or(1.0, |texture| texture.lookup(uv))
    }
}

/// What the colours of a mesh's vertices are multiplied with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tinted {
    /// The colour of the surface: diffuse, of metal, or tint of glass.
    #[default]
    Base,
    /// What it emits.
    Emission,
    /// Nothing: another file says the same colours better.
    Nothing,
}

/// A clear coat over a whole surface.
#[derive(Clone, Debug)]
pub struct ClearCoat {
    /// Share of the surface that it covers, 0 … 1.
    pub cover: Grey,
    /// Its roughness, 0 … 1, whose square α is.
    pub roughness: Grey,
    /// Relief of its own, as [`SurfaceMaps::normals`]; the relief of what lies below does not show on it.
    pub normals: Option<Arc<Texture>>,
}

impl ClearCoat {
    /// The same everywhere, and as even as the mesh.
    pub const fn even(cover: f32, roughness: f32) -> Self {
        Self { cover: Grey::constant(cover), roughness: Grey::constant(roughness), normals: None }
    }
}

/// Glass that a share of an opaque surface is.
#[derive(Clone, Debug)]
pub struct SeeThrough {
    /// The share, 0 … 1, of what is no metal.
    pub share: Grey,
    /// The glass.
    pub glass: Material,
}

/// What may vary over a surface beside its colours.
#[derive(Clone, Debug, Default)]
pub struct SurfaceMaps {
    /// Share of the surface that is there, 0 … 1; rays pass through the rest as if it were not.
    pub opacity: Option<Grey>,
    /// Least opacity of what is there: all of it from that on, and nothing below.
    pub cutoff: Option<f32>,
    /// Normals in the tangent frame of the texture coordinates (+x along u, +y along v, +z outwards), each component
    /// moved from −1 … 1 to 0 … 1.
    pub normals: Option<Arc<Texture>>,
    /// Multiplied with the surface's roughness, whose square α is.
    pub roughness: Option<Arc<GreyTexture>>,
    /// Share of a coated surface that is a metal of the base's colour, 0 … 1.
    pub metallic: Option<Grey>,
    /// What lies over all of it, glass excepted, which has a surface like that already.
    pub clear_coat: Option<ClearCoat>,
    /// What light loses in the inside of glass: of every unit of its way, the natural logarithm of 1 ÷ what is left.
    pub absorption: Vec3,
    /// Multiplied with the reflectance of the coat.
    pub specular: Option<Arc<GreyTexture>>,
    /// Glass that takes the place of all this for a share of the rays.
    pub see_through: Option<Box<SeeThrough>>,
    /// What colours of vertices change.
    pub tinted: Tinted,
    /// What single scattering by rough glass sends on; found out when first needed, for all materials alike.
    glass_albedo: OnceLock<Table<GlassAlbedo>>,
    /// The same of rough metal.
    metal_albedo: OnceLock<Table<MetalAlbedo>>,
}

/// Tables of metal, by the bits of the only roughness.
static METALS: SharedTables<Option<u32>, MetalAlbedo> = SharedTables::new();

/// Tables of glass, by the bits of refractive index and only roughness.
static GLASSES: SharedTables<(u32, Option<u32>), GlassAlbedo> = SharedTables::new();

impl SurfaceMaps {
    /// Share of the surface that is there at texture coordinates `uv`, where the opacity of the vertices is `of_vertices`.
    #[inline]
    pub(crate) fn opacity_at(&self, uv: impl Into<TexCoords>, of_vertices: f32) -> f32 {
        let Some(opacity) = &self.opacity else { return 1.0 };
        let opacity = opacity.at(uv) * of_vertices;
        match self.cutoff {
            None => opacity.clamp(0.0, 1.0),
            Some(cutoff) => f32::from(opacity >= cutoff),
        }
    }

    /// Share of a coated surface that is metal at texture coordinates `uv`.
    #[inline]
    pub(crate) fn metallic_at(&self, uv: TexCoords) -> f32 {
        self.metallic.as_ref().map_or(0.0, |share| share.at(uv).clamp(0.0, 1.0))
    }

    /// Of rough glass of refractive index `ior` and roughness `alpha`, which the map may lower.
    pub(crate) fn glass_albedo(&self, ior: f32, alpha: f32) -> &GlassAlbedo {
        let only = self.only(alpha);
        let table = self.glass_albedo.get_or_init(|| GLASSES.of((ior.to_bits(), only.map(f32::to_bits))));
        table.get_or_init(|| GlassAlbedo::new(ior, only))
    }

    /// Of rough metal of roughness `alpha`, which the map may lower.
    pub(crate) fn metal_albedo(&self, alpha: f32) -> &MetalAlbedo {
        let only = self.only(alpha);
        self.metal_albedo.get_or_init(|| METALS.of(only.map(f32::to_bits))).get_or_init(|| MetalAlbedo::new(only))
    }

    /// `alpha`, when it is the same everywhere.
    fn only(&self, alpha: f32) -> Option<f32> {
        self.roughness.is_none().then_some(alpha.min(1.0))
    }
}

/// How a surface scatters light.
#[derive(Clone, Debug)]
pub enum Surface {
    /// Lambertian.
    Diffuse {
        /// Share of light reflected, 0 … 1.
        reflectance: Colour,
    },
    /// Perfect mirror.
    Mirror {
        /// Share of light reflected, 0 … 1.
        reflectance: Colour,
    },
    /// Clear dielectric, smooth or rough (GGX). The normal's side is the outside.
    Glass {
        /// Refractive index of the inside over that of the outside.
        ior: f32,
        /// Tint of what is transmitted, 0 … 1.
        transmittance: Colour,
        /// GGX roughness parameter α, 0 … 1; 0 is smooth.
        alpha: f32,
    },
    /// Pane of clear glass that is too thin to shift what is seen through it.
    ThinGlass {
        /// Refractive index of the glass over that of what surrounds it.
        ior: f32,
        /// Tint of what passes, 0 … 1.
        transmittance: Colour,
        /// GGX roughness parameter α, 0 … 1: 0 is clear, more is frosted.
        alpha: f32,
    },
    /// Rough metal: GGX with visible normals, Schlick's Fresnel.
    Conductor {
        /// Reflectance at normal incidence, 0 … 1.
        reflectance: Colour,
        /// GGX roughness parameter α (width of the slope distribution), 0 … 1.
        alpha: f32,
    },
    /// A diffuse base under a rough specular coat.
    Coated {
        /// Diffuse reflectance of the base, 0 … 1.
        diffuse: Colour,
        /// Reflectance of the coat at normal incidence, 0 … 1.
        specular: Colour,
        /// GGX roughness parameter α of the coat, 0 … 1.
        alpha: f32,
    },
}

/// A named material.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the scene file.
    pub name: String,
    /// How it scatters.
    pub surface: Surface,
    /// Emitted radiance on the side the geometric normal points to; zero for most.
    pub emission: Colour,
    /// What else varies.
    pub maps: SurfaceMaps,
}

impl Material {
    /// A material that emits the same everywhere and has no maps.
    pub fn new(name: impl Into<String>, surface: Surface, emission: Vec3) -> Self {
        Self { name: name.into(), surface, emission: Colour::constant(emission), maps: SurfaceMaps::default() }
    }

    /// Whether any of it emits.
    pub fn emits(&self) -> bool {
        self.emission.factor != Vec3::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_of_the_same_roughness_and_index_share_their_tables() {
        let rough = SurfaceMaps { roughness: Some(Arc::new(GreyTexture::new(1, 1, vec![0.5]))), ..Default::default() };
        let [other, plain] = [rough.clone(), SurfaceMaps::default()];
        assert!(std::ptr::eq(rough.metal_albedo(0.2), other.metal_albedo(0.7)));
        assert!(!std::ptr::eq(rough.metal_albedo(0.2), plain.metal_albedo(0.2)));
        let [same, denser] = [SurfaceMaps::default(), SurfaceMaps::default()];
        assert!(std::ptr::eq(plain.glass_albedo(1.25, 0.3), same.glass_albedo(1.25, 0.3)));
        assert!(!std::ptr::eq(plain.glass_albedo(1.25, 0.3), denser.glass_albedo(1.5, 0.3)));
    }
}
