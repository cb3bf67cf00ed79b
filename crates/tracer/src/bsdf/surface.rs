//! A lobe at a point of the scene.

use glam::{Vec2, Vec3};

use super::clear_coat::{self, ClearCoat};
use super::frame::{Frame, above};
use super::horizon::lifted;
use super::{Coated, Conductor, Diffuse, Glass, Lobe, Mirror, RoughGlass, RoughPane, Scattered, ThinGlass, fresnel};
use crate::interaction::Interaction;
use crate::light::Receiver;
use crate::material::{Colour, Grey, Material, Surface, SurfaceMaps, Tinted};
use crate::texture::TexCoords;

/// Metals and glass smoother than this are perfectly smooth: their highlight is narrower than any pixel.
const SMOOTH_ALPHA: f32 = 1e-3;

/// Glass whose index is as near to 1 as this does not bend light, however rough it is: between a direction and its opposite there
/// is no telling which facet refracts.
const CLEAR: f32 = 1e-5;

/// A direction chosen by [`Bsdf::sample_direction`].
#[derive(Clone, Copy, Debug)]
pub struct DirectionSample {
    /// Where the light comes from; unit length, in the world.
    pub direction: Vec3,
    /// f·|cos θ| ÷ pdf.
    pub weight: Vec3,
    /// Density per solid angle; `None` when the direction was the only one possible (a delta distribution).
    pub pdf: Option<f32>,
    /// Refractive index on the incoming side over that on the outgoing side; 1 when reflected.
    pub eta: f32,
}

/// How the surface at one point scatters light towards one viewer.
///
/// Two normals, two dangers (Veach 1997, section 5.3). Lobes live around the shading normal; what they reflect must
/// stay on the viewer's side of the *real* surface, and what they transmit beyond it, or light leaks through walls.
/// A viewer below the shading horizon (at silhouettes of coarse meshes) sees the geometric normal instead. A perfect
/// mirror or glass whose direction would leak takes the geometric normal too, so it keeps its energy. The normal of
/// metal in relief is bent back until what it mirrors is above the surface; what else of rough lobes would leak is lost.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    position: Vec3,
    frame: Frame,
    /// On the viewer's side.
    geometric_normal: Vec3,
    outgoing: Vec3,
    local_outgoing: Vec3,
    lobe: Lobe,
    /// What lies over the lobe.
    coat: Option<ClearCoat>,
    albedo: Vec3,
}

impl Bsdf {
    /// The scattering at `interaction` towards its viewer. Reflectances are clamped to 0 … 1.
    pub fn at(interaction: &Interaction) -> Self {
        let outgoing = interaction.outgoing;
        let outside = interaction.geometric_normal.dot(outgoing) >= 0.0;
        let side = if outside { 1.0 } else { -1.0 };
        let geometric_normal = side * interaction.geometric_normal;
        let shading_normal = side * interaction.shading_normal;
        let normal = if shading_normal.dot(outgoing) > 0.0 { shading_normal } else { geometric_normal };
        // Relief lets metal mirror what is below the surface, where no light comes from.
        let metal = if interaction.material.maps.normals.is_some() { metal_share(interaction) } else { 0.0 };
        let normal = if metal > 0.0 {
            normal.lerp(lifted(normal, geometric_normal, outgoing), metal).normalize_or(geometric_normal)
        } else {
            normal
        };
        let frame = Frame::new(normal);
        let local_outgoing = above(frame.to_local(outgoing));
        let (lobe, mut albedo) = lobe_at(interaction, outside, local_outgoing.z);
        let coat = interaction.material.maps.clear_coat.as_ref();
        let coat = coat.filter(|_| !lobe.is_glass()).and_then(|coat| {
            let cover = coat.cover.at(interaction.uv).clamp(0.0, 1.0);
            let own = side * interaction.coat_normal;
            let normal = if own.dot(outgoing) > 0.0 { own } else { geometric_normal };
            let normal = lifted(normal, geometric_normal, outgoing);
            let below = albedo;
            albedo = albedo.lerp(Vec3::ONE, cover * clear_coat::REFLECTANCE);
            let alpha = coat.roughness.at(interaction.uv).powi(2);
            (cover > 0.0).then(|| ClearCoat::new(cover, alpha, normal, outgoing, below))
        });
        Self { position: interaction.position, frame, geometric_normal, outgoing, local_outgoing, lobe, coat, albedo }
    }

    /// Whether it scatters into single directions only: a perfect mirror or clear glass.
    #[inline]
    pub const fn is_specular(&self) -> bool {
        self.lobe.is_specular()
    }

    /// Whether it looks equally bright from all sides.
    #[inline]
    pub const fn is_diffuse(&self) -> bool {
        self.lobe.is_diffuse() && self.coat.is_none()
    }

    /// What a part of it reflects to the viewer that looks equally bright from all sides, but for a factor that this
    /// includes: a diffuse surface, or the base of a coated one. `None` where there is no such part.
    #[inline]
    pub fn even_albedo(&self) -> Option<Vec3> {
        let below = self.lobe.even_albedo();
        if let Some(coat) = &self.coat { below.map(|albedo| coat.passed * albedo) } else { below }
    }

    /// The share of that part in what is reflected of light from the unit vector `incoming`.
    #[inline]
    pub fn even_share(&self, incoming: Vec3) -> Vec3 {
        let Some(local) = self.local_incoming(incoming) else { return Vec3::ZERO };
        let below = self.lobe.even_share(self.local_outgoing, local);
        let Some(coat) = &self.coat else { return below };
        let even = coat.passed * below * self.lobe.evaluate(self.local_outgoing, local);
        (even / self.evaluate(incoming).max(Vec3::splat(f32::MIN_POSITIVE))).min(Vec3::ONE)
    }

    /// What the albedo feature holds, 0 … 1: diffuse reflectance, reflectance at normal incidence of metals and mirrors,
    /// tint of glass; of a coated surface F₀ + (1 − F₀) k_d, and what of it is metal as metal; below a clear coat likewise.
    #[inline]
    pub const fn albedo(&self) -> Vec3 {
        self.albedo
    }

    /// The normal that lobes are built around, on the viewer's side.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        self.frame.to_world(Vec3::Z)
    }

    /// Whether light from beyond the surface matters, too.
    #[inline]
    pub const fn is_two_sided(&self) -> bool {
        self.lobe.is_two_sided()
    }

    /// Where it is and where it looks for light.
    #[inline]
    pub fn receiver(&self) -> Receiver {
        // Light from below the horizon of the surface matters to a coat that faces another way.
        let faces_both = self.coat.as_ref().is_some_and(|coat| coat.normal() != self.normal());
        Receiver { position: self.position, normal: self.normal(), two_sided: self.is_two_sided() || faces_both }
    }

    /// Whether light from `direction` can be scattered to the viewer: from above both horizons, the shading and the
    /// geometric one, or from below both.
    #[inline]
    pub fn is_reached_from(&self, direction: Vec3) -> bool {
        let above = [self.geometric_normal, self.normal()].map(|normal| normal.dot(direction));
        (above[0] > 0.0 && above[1] > 0.0)
            || (self.is_two_sided() && above[0] < 0.0 && above[1] < 0.0)
            || (above[0] > 0.0 && self.coat.as_ref().is_some_and(|coat| coat.normal().dot(direction) > 0.0))
    }

    /// Chooses a direction to follow the light back, from a number `choice` in [0, 1) and a point `u` in [0, 1)².
    /// `None` when the light is absorbed or would leak through the surface.
    pub fn sample_direction(&self, choice: f32, u: Vec2) -> Option<DirectionSample> {
        if let Some(coat) = &self.coat {
            return self.sample_coated(coat, choice, u);
        }
        let sample = self.sample_in(self.frame, self.local_outgoing, choice, u);
        if sample.is_none() && self.is_specular() {
            let frame = Frame::new(self.geometric_normal);
            return self.sample_in(frame, above(frame.to_local(self.outgoing)), choice, u);
        }
        sample
    }

    fn sample_in(&self, frame: Frame, outgoing: Vec3, choice: f32, u: Vec2) -> Option<DirectionSample> {
        let Scattered { incoming, weight, pdf, eta } = self.lobe.sample_direction(outgoing, choice, u)?;
        let direction = frame.to_world(incoming);
        let leaks = (incoming.z > 0.0) != (self.geometric_normal.dot(direction) > 0.0);
        (!leaks).then_some(DirectionSample { direction, weight, pdf, eta })
    }

    /// From the coat or from what lies below it.
    fn sample_coated(&self, coat: &ClearCoat, choice: f32, u: Vec2) -> Option<DirectionSample> {
        let direction = if choice < coat.share {
            coat.sample_direction(u)?
        } else {
            let choice = (choice - coat.share) / (1.0 - coat.share);
            self.frame.to_world(self.lobe.sample_direction(self.local_outgoing, choice, u)?.incoming)
        };
        // Never below the real surface: there the density is 0.
        let pdf = self.direction_pdf(direction);
        let sample = || DirectionSample { direction, weight: self.evaluate(direction) / pdf, pdf: Some(pdf), eta: 1.0 };
        (pdf > 0.0).then(sample)
    }

    /// Density per solid angle of [`sample_direction`](Self::sample_direction) for the unit vector `incoming`; 0 for
    /// specular surfaces.
    #[inline]
    pub fn direction_pdf(&self, incoming: Vec3) -> f32 {
        let local = self.local_incoming(incoming);
        let below = local.map_or(0.0, |local| self.lobe.direction_pdf(self.local_outgoing, local));
        match &self.coat {
            None => below,
            Some(_) if self.geometric_normal.dot(incoming) <= 0.0 => 0.0,
            Some(coat) => coat.share * coat.direction_pdf(incoming) + (1.0 - coat.share) * below,
        }
    }

    /// f·cos θ for light from the unit vector `incoming`; 0 for specular surfaces, and where shading normal and geometric
    /// normal do not agree on the side it comes from.
    #[inline]
    pub fn evaluate(&self, incoming: Vec3) -> Vec3 {
        let local = self.local_incoming(incoming);
        let below = local.map_or(Vec3::ZERO, |local| self.lobe.evaluate(self.local_outgoing, local));
        match &self.coat {
            None => below,
            Some(_) if self.geometric_normal.dot(incoming) <= 0.0 => Vec3::ZERO,
            Some(coat) => coat.passed * below + coat.evaluate(incoming),
        }
    }

    /// `incoming` in the local frame, unless it could only leak from there.
    #[inline]
    fn local_incoming(&self, incoming: Vec3) -> Option<Vec3> {
        let above = self.geometric_normal.dot(incoming) > 0.0;
        if !(above || self.is_two_sided()) {
            return None;
        }
        let local = self.frame.to_local(incoming);
        (above == (local.z > 0.0)).then_some(local)
    }
}

/// Whether a surface of `material` scatters into single directions only, anywhere.
pub(crate) fn may_be_specular(material: &Material) -> bool {
    let maps = &material.maps;
    let least = maps.roughness.as_ref().map_or(1.0, |map| map.range()[0].max(0.0));
    let is_smooth = |alpha: f32| alpha * least.powi(2) < SMOOTH_ALPHA;
    maps.see_through.as_ref().is_some_and(|see_through| may_be_specular(&see_through.glass))
        || match &material.surface {
            Surface::ThinGlass { alpha, .. } => is_smooth(*alpha),
            Surface::Glass { ior, alpha, .. } => is_smooth(*alpha) || is_clear(*ior),
            // Below a clear coat everything is a little rough.
            _ if maps.clear_coat.is_some() => false,
            Surface::Mirror { .. } => true,
            Surface::Conductor { alpha, .. } => is_smooth(*alpha),
            // What is metal is a conductor.
            Surface::Coated { alpha, .. } => maps.metallic.as_ref().is_some_and(may_be_whole) && is_smooth(*alpha),
            Surface::Diffuse { .. } => false,
        }
}

/// Whether `share` is 1 somewhere.
fn may_be_whole(share: &Grey) -> bool {
    share.factor * share.texture.as_ref().map_or(1.0, |map| map.range()[1]) >= 1.0
}

/// Whether glass of refractive index `ior` lets all light pass straight.
fn is_clear(ior: f32) -> bool {
    (ior - 1.0).abs() < CLEAR
}

/// The lobe and the albedo feature of `interaction`'s material, seen from the outside or not, with cosine `cosine`.
fn lobe_at(interaction: &Interaction, outside: bool, cosine: f32) -> (Lobe, Vec3) {
    let uv = interaction.uv;
    let maps = &interaction.material.maps;
    let tint = if maps.tinted == Tinted::Base { interaction.tint } else { Vec3::ONE };
    let colour = |colour: &Colour| tint * colour_at(colour, uv);
    let roughness = |alpha: &f32| maps.roughness.as_ref().map_or(*alpha, |map| alpha * map.lookup(uv).powi(2));
    match &interaction.material.surface {
        Surface::Diffuse { reflectance } => {
            let reflectance = colour(reflectance);
            (Lobe::Diffuse(Diffuse { reflectance }), reflectance)
        }
        Surface::Mirror { reflectance } if maps.clear_coat.is_some() => {
            let reflectance = colour(reflectance);
            (conductor(reflectance, [0.0; 2], cosine, maps), reflectance)
        }
        Surface::Mirror { reflectance } => {
            let reflectance = colour(reflectance);
            (Lobe::Mirror(Mirror { reflectance }), reflectance)
        }
        Surface::Glass { ior, transmittance, alpha } => {
            let transmittance = colour(transmittance);
            let eta = if outside { *ior } else { 1.0 / ior };
            let alpha_here = roughness(alpha).min(1.0);
            if alpha_here < SMOOTH_ALPHA || is_clear(*ior) {
                return (Lobe::Glass(Glass { eta, transmittance }), transmittance);
            }
            let albedo = maps.glass_albedo(*ior, *alpha).directional(outside, alpha_here, cosine);
            (Lobe::RoughGlass(RoughGlass::new(eta, transmittance, alpha_here, albedo)), transmittance)
        }
        Surface::ThinGlass { ior, transmittance, alpha } => {
            let transmittance = colour(transmittance);
            let alpha_here = roughness(alpha).min(1.0);
            if alpha_here >= SMOOTH_ALPHA {
                let albedo = maps.metal_albedo(*alpha).directional(alpha_here, cosine);
                let pane = RoughPane::new(*ior, transmittance, alpha_here, albedo);
                return (Lobe::RoughPane(pane), transmittance);
            }
            (Lobe::ThinGlass(ThinGlass { ior: *ior, transmittance }), transmittance)
        }
        Surface::Conductor { reflectance, alpha } => {
            let reflectance = colour(reflectance);
            (conductor(reflectance, [*alpha, roughness(alpha)], cosine, maps), reflectance)
        }
        Surface::Coated { diffuse, specular, alpha } => {
            let (diffuse, specular) = (colour(diffuse), colour_at(specular, uv));
            let specular = maps.specular.as_ref().map_or(specular, |map| specular * map.lookup(uv).clamp(0.0, 1.0));
            let metallic = maps.metallic_at(uv);
            if metallic >= 1.0 {
                return (conductor(diffuse, [*alpha, roughness(alpha)], cosine, maps), diffuse);
            }
            coated(diffuse, specular, roughness(alpha), metallic, cosine)
        }
    }
}

/// Share of the surface that is metal at `interaction`.
fn metal_share(interaction: &Interaction) -> f32 {
    let Interaction { material, uv, .. } = *interaction;
    match &material.surface {
        Surface::Mirror { .. } | Surface::Conductor { .. } => 1.0,
        Surface::Coated { .. } => material.maps.metallic_at(uv),
        Surface::Diffuse { .. } | Surface::Glass { .. } | Surface::ThinGlass { .. } => 0.0,
    }
}

/// A coated base, of which the share `metallic` is a metal of its colour.
fn coated(base: Vec3, coat: Vec3, alpha: f32, metallic: f32, cosine: f32) -> (Lobe, Vec3) {
    let albedo = (1.0 - metallic) * (coat + (Vec3::ONE - coat) * base) + metallic * base;
    (Lobe::Coated(Coated::new(base, coat, metallic, alpha, cosine)), albedo)
}

/// A metal whose roughness is `alphas[1]` here and `alphas[0]` where the map does not lower it. Below a clear coat it is never
/// a mirror, so that such surfaces have one kind of event.
fn conductor(reflectance: Vec3, alphas: [f32; 2], cosine: f32, maps: &SurfaceMaps) -> Lobe {
    let least = if maps.clear_coat.is_some() { SMOOTH_ALPHA } else { 0.0 };
    let alphas = alphas.map(|alpha| alpha.max(least));
    let alpha = alphas[1].min(1.0);
    if alpha < SMOOTH_ALPHA {
        return Lobe::Mirror(Mirror { reflectance: fresnel::schlick(reflectance, cosine) });
    }
    let albedo = maps.metal_albedo(alphas[0]).directional(alpha, cosine);
    Lobe::Conductor(Conductor::new(reflectance, alpha, albedo))
}

/// `colour` at texture coordinates `uv`, clamped to 0 … 1.
fn colour_at(colour: &Colour, uv: TexCoords) -> Vec3 {
    colour.at(uv).clamp(Vec3::ZERO, Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Material;

    fn material(surface: Surface) -> Material {
        Material::new("test", surface, Vec3::ZERO)
    }

    fn seen(material: &Material, normals: [Vec3; 2], outgoing: Vec3) -> Bsdf {
        let facing = Interaction::facing(Vec3::ZERO, normals[0], material);
        Bsdf::at(&Interaction {
            shading_normal: normals[1],
            coat_normal: normals[1],
            outgoing,
            distance: 1.0,
            ..facing
        })
    }

    fn grey(value: f32) -> Colour {
        Colour::constant(Vec3::splat(value))
    }

    /// A shading normal 60° off the real one.
    fn tilted() -> Vec3 {
        Vec3::new(0.75_f32.sqrt(), 0.0, 0.5)
    }

    #[test]
    fn nothing_leaks_through_a_surface_with_a_tilted_shading_normal() {
        let surfaces = [
            Surface::Diffuse { reflectance: grey(0.5) },
            Surface::Mirror { reflectance: grey(0.5) },
            Surface::Conductor { reflectance: grey(0.5), alpha: 0.3 },
            Surface::Coated { diffuse: grey(0.5), specular: grey(0.1), alpha: 0.3 },
        ];
        for surface in surfaces {
            let material = material(surface);
            for outgoing in [Vec3::new(0.8, 0.0, 0.6), Vec3::new(-0.8, 0.0, 0.6), Vec3::new(0.6, 0.0, -0.8)] {
                let bsdf = seen(&material, [Vec3::Z, tilted()], outgoing);
                for i in 0..256 {
                    let u = Vec2::new((i % 16) as f32 + 0.5, (i / 16) as f32 + 0.5) / 16.0;
                    let Some(sample) = bsdf.sample_direction(0.3, u) else { continue };
                    assert!(sample.direction.z * outgoing.z > 0.0, "{material:?} {outgoing}");
                }
                let beyond = Vec3::new(0.9, 0.0, -0.2 * outgoing.z.signum()).normalize();
                assert_eq!(bsdf.evaluate(beyond), Vec3::ZERO);
                assert_eq!(bsdf.direction_pdf(beyond), 0.0);
            }
        }
    }

    #[test]
    fn mirror_and_glass_keep_their_energy_at_silhouettes() {
        for surface in [
            Surface::Mirror { reflectance: grey(1.0) },
            Surface::Glass { ior: 1.5, transmittance: grey(1.0), alpha: 0.0 },
        ] {
            let material = material(surface);
            for angle in 0..200 {
                let (sin, cos) = (angle as f32 / 200.0 * std::f32::consts::TAU).sin_cos();
                if cos.abs() < 1e-3 {
                    continue;
                }
                let bsdf = seen(&material, [Vec3::Z, tilted()], Vec3::new(sin, 0.0, cos));
                let sample = bsdf.sample_direction(0.999, Vec2::ZERO).unwrap();
                assert!((sample.weight * sample.eta * sample.eta - Vec3::ONE).length() < 1e-5, "{angle}");
            }
        }
    }

    /// A white furnace, and a normal map that bends the normal so far that a mirror would show what is below the surface.
    #[test]
    fn metal_in_relief_does_not_go_dark() {
        let flat = std::sync::Arc::new(crate::texture::Texture::new(1, 1, vec![[0.5, 0.5, 1.0]]));
        for alpha in [0.0, 0.02, 0.16] {
            let mut metal = material(Surface::Conductor { reflectance: grey(1.0), alpha });
            let seen_now = |material: &Material| {
                let bsdf = seen(material, [Vec3::Z, tilted()], Vec3::Z);
                let weight = |i: usize| {
                    let u = (Vec2::new((i % 32) as f32, (i / 32) as f32) + 0.5) / 32.0;
                    bsdf.sample_direction(0.5, u).map_or(0.0, |sample| sample.weight.x)
                };
                (0..1024).map(weight).sum::<f32>() / 1024.0
            };
            let without = seen_now(&metal);
            metal.maps.normals = Some(flat.clone());
            let with = seen_now(&metal);
            assert!(with > 0.45 && (without < 0.2 || alpha == 0.0), "{alpha}: {with} {without}");
        }
    }

    #[test]
    fn smooth_metal_is_a_mirror_with_schlick_s_reflectance() {
        let material = material(Surface::Conductor { reflectance: grey(0.5), alpha: 1e-4 });
        let bsdf = seen(&material, [Vec3::Z; 2], Vec3::new(0.75_f32.sqrt(), 0.0, 0.5));
        assert!(bsdf.is_specular());
        let sample = bsdf.sample_direction(0.0, Vec2::ZERO).unwrap();
        assert!((sample.weight.x - (0.5 + 0.5 / 32.0)).abs() < 1e-6);
        assert_eq!(bsdf.albedo(), Vec3::splat(0.5));
    }

    #[test]
    fn glass_bends_towards_the_normal_from_outside_and_away_from_inside() {
        let material = material(Surface::Glass { ior: 1.5, transmittance: grey(1.0), alpha: 0.0 });
        let outgoing = Vec3::new(0.5, 0.0, 0.75_f32.sqrt());
        let from_outside = seen(&material, [Vec3::Z; 2], outgoing).sample_direction(0.99, Vec2::ZERO).unwrap();
        assert!((from_outside.direction.x + 0.5 / 1.5).abs() < 1e-6);
        let from_inside = seen(&material, [-Vec3::Z; 2], outgoing).sample_direction(0.99, Vec2::ZERO).unwrap();
        assert!((from_inside.direction.x + 0.5 * 1.5).abs() < 1e-6);
    }

    #[test]
    fn the_base_of_a_coat_looks_the_same_from_all_sides_but_for_a_factor() {
        let material = material(Surface::Coated { diffuse: grey(0.5), specular: grey(0.2), alpha: 0.3 });
        let viewers = [Vec3::Z, Vec3::new(0.8, 0.0, 0.6), Vec3::new(0.0, -0.96, 0.28)];
        for incoming in [Vec3::new(0.0, 0.6, 0.8), Vec3::new(-0.8, 0.0, 0.6)] {
            let seen_as = viewers.map(|viewer| {
                let bsdf = seen(&material, [Vec3::Z; 2], viewer);
                let even = bsdf.even_share(incoming) * bsdf.evaluate(incoming);
                assert!(even.cmple(bsdf.evaluate(incoming)).all() && bsdf.even_share(incoming).min_element() > 0.2);
                even / bsdf.even_albedo().unwrap()
            });
            assert!(seen_as.iter().all(|seen| (*seen / seen_as[0] - Vec3::ONE).abs().max_element() < 1e-5));
        }
        let diffuse = self::material(Surface::Diffuse { reflectance: grey(0.5) });
        assert_eq!(seen(&diffuse, [Vec3::Z; 2], Vec3::Z).even_share(Vec3::Z), Vec3::ONE);
    }

    #[test]
    fn a_map_makes_a_surface_specular_only_where_it_is_smooth() {
        let map = |texels: [f32; 2]| Some(std::sync::Arc::new(crate::texture::GreyTexture::new(2, 1, texels.into())));
        let mapped = |surface: Surface, roughness, metallic: [f32; 2]| {
            let mut material = material(surface);
            material.maps.roughness = map(roughness);
            material.maps.metallic = Some(Grey { factor: 1.0, texture: map(metallic) });
            may_be_specular(&material)
        };
        let metal = || Surface::Conductor { reflectance: grey(0.5), alpha: 1.0 };
        let coated = || Surface::Coated { diffuse: grey(0.5), specular: grey(0.1), alpha: 1.0 };
        assert!(mapped(metal(), [0.0, 0.5], [0.0; 2]) && !mapped(metal(), [0.1, 0.5], [0.0; 2]));
        assert!(mapped(coated(), [0.0, 0.5], [0.0, 1.0]));
        assert!(!mapped(coated(), [0.1, 0.5], [0.0, 1.0]) && !mapped(coated(), [0.0, 0.5], [0.0, 0.9]));
    }

    #[test]
    fn albedos_are_clamped_and_bounded() {
        let diffuse = material(Surface::Diffuse { reflectance: grey(3.0) });
        assert_eq!(seen(&diffuse, [Vec3::Z; 2], Vec3::Z).albedo(), Vec3::ONE);
        let coated = material(Surface::Coated { diffuse: grey(0.5), specular: grey(0.2), alpha: 0.3 });
        assert!((seen(&coated, [Vec3::Z; 2], Vec3::Z).albedo().x - 0.6).abs() < 1e-6);
    }
}
