//! Surfaces that are not there everywhere: cut-outs and veils; and those of which a share is glass.
//!
//! Whether a ray meets a surface of opacity o is decided once for every pair of a ray and a triangle: by a number in
//! [0, 1) hashed from both, which is below o in a share o of all rays. So all rays, those for visibility included, see a
//! surface through which the share 1 − o of them passes, without bias, and the same ray always finds the same (pbrt-v4,
//! section 10.5.1; there, only the ray is hashed). Each triangle has a number of its own, so that two veils of one half
//! let a quarter pass. Another number decides in the same way what is glass.

use super::Scene;
use crate::Ray;
use crate::bvh::TriangleHit;
use crate::material::Material;
use crate::texture::TexCoords;

impl Scene {
    /// Whether `ray` meets the triangle at `hit` on `placed`, or passes through a hole in it.
    pub(super) fn is_there(&self, placed: usize, ray: &Ray, hit: &TriangleHit) -> bool {
        let mesh = &self.meshes[self.placed[placed].mesh].mesh;
        let material = &self.materials[mesh.materials[hit.triangle as usize] as usize];
        if material.maps.opacity.is_none() {
            return true;
        }
        let opacity = material.maps.opacity_at(mesh.uv(hit), mesh.colour(hit).w);
        opacity > 0.0 && (opacity >= 1.0 || opacity > number(ray, placed, hit.triangle, 0))
    }
}

/// The material that `ray` meets on the triangle `triangle` of `placed`: `material`, or the glass that a share of it is.
///
/// Where a part is metal, a share of the rest is glass; the rest of that keeps its mixture with metal, which is right where it
/// is either.
pub(super) fn as_met<'a>(
    material: &'a Material,
    uv: TexCoords,
    ray: &Ray,
    placed: usize,
    triangle: u32,
) -> &'a Material {
    let Some(see_through) = &material.maps.see_through else { return material };
    let share = see_through.share.at(uv) * (1.0 - material.maps.metallic_at(uv));
    if share > number(ray, placed, triangle, OF_GLASS) { &see_through.glass } else { material }
}

/// Makes the number of glass another than that of opacity.
const OF_GLASS: u64 = 0x676c_6173_7300_0000;

/// A number in [0, 1) that depends on ray, placed mesh and triangle, and on what it is `of`.
fn number(ray: &Ray, placed: usize, triangle: u32, of: u64) -> f32 {
    let words = [ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y, ray.direction.z, ray.time];
    let start = (placed as u64) << 32 | u64::from(triangle);
    let hash = words.iter().fold(mixed(start ^ of), |hash, word| mixed(hash ^ u64::from(word.to_bits())));
    (hash >> 40) as f32 / (1 << 24) as f32
}

/// The finaliser of SplitMix64 (Steele et al. 2014): every bit of the result depends on every bit of `x`.
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Vec2, Vec3};

    use super::super::{Instance, Mesh, Placement};
    use super::*;
    use crate::bvh::random::Random;
    use crate::material::{Colour, Grey, SeeThrough, Surface};
    use crate::texture::GreyTexture;

    /// `layers` unit squares at z = 0, −1 …, of the opacity given.
    fn veils(layers: usize, opacity: Grey) -> Scene {
        let dull = Surface::Diffuse { reflectance: Colour::constant(Vec3::ZERO) };
        let mut material = Material::new("veil", dull, Vec3::ZERO);
        material.maps.opacity = Some(opacity);
        let mut mesh = Mesh::default();
        for layer in 0..layers as u32 {
            let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
            mesh.positions.extend(corners.map(|c| c.extend(-(layer as f32))));
            mesh.uvs.extend(corners);
            mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|v| v + 4 * layer)));
            mesh.materials.extend([0, 0]);
        }
        let stand = Instance { mesh: 0, placement: Placement::IDENTITY, motion: None };
        Scene::new(vec![mesh], vec![stand], vec![material], None).unwrap()
    }

    fn ray(random: &mut Random) -> Ray {
        let origin = Vec3::new(0.5, 0.5, 1.0) + 0.1 * random.point();
        Ray { origin, direction: (-Vec3::Z + 0.05 * random.direction()).normalize(), t_max: f32::INFINITY, time: 0.0 }
    }

    #[test]
    fn every_veil_lets_its_share_of_rays_pass() {
        for (layers, opacity) in [(1, 0.3), (2, 0.5), (3, 0.2), (2, 0.0), (2, 1.0)] {
            let scene = veils(layers, Grey::constant(opacity));
            let mut random = Random(4);
            let rays = 40_000;
            let passed = (0..rays)
                .filter(|_| {
                    let ray = ray(&mut random);
                    let hit = scene.intersect(&ray).is_some();
                    assert_eq!(hit, scene.occluded(&ray), "all rays find the same");
                    !hit
                })
                .count() as f32
                / rays as f32;
            let expected = (1.0 - opacity).powi(layers as i32);
            // Four standard errors of a share.
            let error = 4.0 * (expected * (1.0 - expected) / rays as f32).sqrt();
            assert!((passed - expected).abs() <= error, "{layers} {opacity}: {passed} {expected}");
        }
    }

    #[test]
    fn a_share_of_what_is_there_and_no_metal_is_glass() {
        let mut scene = veils(1, Grey::constant(0.5));
        let tint = Colour::constant(Vec3::ONE);
        let pane = Surface::ThinGlass { ior: 1.5, transmittance: tint, alpha: 0.0 };
        let glass = Material::new("pane", pane, Vec3::ZERO);
        let maps = &mut scene.materials[0].maps;
        maps.see_through = Some(Box::new(SeeThrough { share: Grey::constant(0.6), glass }));
        // The right half is metal.
        let halves = GreyTexture::new(4, 1, vec![0.0, 0.0, 1.0, 1.0]);
        maps.metallic = Some(Grey { factor: 1.0, texture: Some(Arc::new(halves)) });
        let mut random = Random(7);
        for (x, expected) in [(0.2, 0.6), (0.8, 0.0)] {
            let rays = (0..40_000).map(|_| {
                let origin = Vec3::new(x, 0.5, 1.0) + 0.05 * random.point();
                Ray { origin, direction: -Vec3::Z, t_max: f32::INFINITY, time: 0.0 }
            });
            let met: Vec<bool> = rays
                .filter_map(|ray| scene.intersect(&ray))
                .map(|hit| matches!(hit.material.surface, Surface::ThinGlass { .. }))
                .collect();
            let share = met.iter().filter(|is_glass| **is_glass).count() as f32 / met.len() as f32;
            assert!((share - expected).abs() < 0.015, "{x}: {share}");
        }
    }

    #[test]
    fn holes_are_where_the_texture_has_them() {
        // The left half is a hole; no ray near the seam is asked.
        let texture = GreyTexture::new(4, 1, vec![0.0, 0.0, 1.0, 1.0]);
        let scene = veils(1, Grey { factor: 1.0, texture: Some(Arc::new(texture)) });
        let at = |x: f32| Ray { origin: Vec3::new(x, 0.5, 1.0), direction: -Vec3::Z, t_max: 9.0, time: 0.0 };
        for i in 0..30 {
            let x = 0.13 + i as f32 * 0.008;
            assert!(scene.intersect(&at(x)).is_none() && scene.intersect(&at(x + 0.5)).is_some(), "{x}");
        }
    }
}
