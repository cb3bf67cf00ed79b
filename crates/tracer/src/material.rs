//! What a surface is made of, as data: loaders fill it in, `bsdf` turns it into scattering at a point.

use std::sync::Arc;

use glam::Vec3;

use crate::texture::Texture;

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
    /// Clear smooth dielectric. The normal's side is the outside.
    Glass {
        /// Refractive index of the inside over that of the outside.
        ior: f32,
        /// Tint of what is transmitted, 0 … 1.
        transmittance: Colour,
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
    pub emission: Vec3,
}
