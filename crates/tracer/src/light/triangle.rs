//! A triangle that emits from one side, sampled uniformly over its area.

use glam::{Vec2, Vec3};

use super::light_sample::LightSample;
use crate::interaction::Interaction;
use crate::material::Material;
use crate::sampler::warp::sample_triangle;
use crate::scene::EmissiveTriangle;
use crate::texture::TexCoords;

/// A point on `light` as seen from `from`; `None` behind it, in its plane, or on it.
pub(super) fn sample(
    light: &EmissiveTriangle,
    material: &Material,
    from: &Interaction,
    u: Vec2,
) -> Option<LightSample> {
    let weights = sample_triangle(u);
    let corners = light.vertices;
    let point = weighted(weights, corners);
    let span = point - from.position;
    let distance = span.length();
    let direction = span / distance;
    let pdf = solid_angle_pdf(light, distance, -light.normal.dot(direction));
    if !(pdf > 0.0 && pdf.is_finite()) {
        return None;
    }
    let shadow_ray = from.spawn_to(point, light.normal, rounding(weights, corners));
    Some(LightSample { direction, radiance: radiance(light, material, weights), pdf, is_delta: false, shadow_ray })
}

/// The point of `light` chosen by `u`, uniform over its area, seen from along its normal; and its radiance.
pub(super) fn point<'a>(light: &EmissiveTriangle, material: &'a Material, u: Vec2) -> (Interaction<'a>, Vec3) {
    let weights = sample_triangle(u);
    let point = Interaction {
        position_error: rounding(weights, light.vertices),
        ..Interaction::facing(weighted(weights, light.vertices), light.normal, material)
    };
    (point, radiance(light, material, weights))
}

fn weighted(weights: [f32; 3], corners: [Vec3; 3]) -> Vec3 {
    weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2]
}

/// Radiance of the point with barycentric coordinates `weights`. A light that is not there everywhere shines by the share
/// that is: the ray towards it ends before it could pass through.
fn radiance(light: &EmissiveTriangle, material: &Material, weights: [f32; 3]) -> Vec3 {
    if !light.varies {
        return light.radiance;
    }
    let uv = TexCoords::weighted(weights, light.uvs);
    let tint = weights[0] * light.tints[0] + weights[1] * light.tints[1] + weights[2] * light.tints[2];
    material.maps.opacity_at(uv, tint.w) * tint.truncate() * material.emission.at(uv)
}

/// Density per solid angle with which the point `seen` of `light` is sampled from where the ray to it began.
pub(super) fn pdf(light: &EmissiveTriangle, seen: &Interaction) -> f32 {
    solid_angle_pdf(light, seen.distance, light.normal.dot(seen.outgoing))
}

/// 1/A per area, turned into solid angle at `distance` under `cosine` at the light.
fn solid_angle_pdf(light: &EmissiveTriangle, distance: f32, cosine: f32) -> f32 {
    if cosine > 0.0 { distance * distance / (cosine * light.area) } else { 0.0 }
}

/// Bound of the rounding error of a weighted sum of corners (pbrt-v4, section 6.8.5): γ₆ times the sum of magnitudes.
fn rounding(weights: [f32; 3], corners: [Vec3; 3]) -> Vec3 {
    const HALF_ULPS: f32 = 6.0 * 0.5 * f32::EPSILON;
    const GAMMA: f32 = HALF_ULPS / (1.0 - HALF_ULPS);
    GAMMA * (0..3).map(|i| (weights[i] * corners[i]).abs()).sum::<Vec3>()
}
