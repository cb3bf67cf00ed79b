//! Cameras outside.

use glam::Vec3;

use super::super::Scene;
use super::probe::{HORIZONTAL, Side, side};
use super::rounded;
use crate::camera::CameraDescription;

/// Field of view into a box, as in most pictures of Cornell's.
const BOX_FOV: f32 = 30.0;

/// Field of view round an object.
const OBJECT_FOV: f32 = 40.0;

/// A camera in front of the open side of a box, when exactly one horizontal side is open and the others are walls. The
/// opening fills the picture's height.
pub(super) fn into_open_box(scene: &Scene) -> Option<CameraDescription> {
    let sides = HORIZONTAL.map(|outward| side(scene, outward));
    let is_open = |s: &Side| s.deep > 0.6 && s.wall < 0.3;
    let is_wall = |s: &Side| s.wall > 0.8;
    let walls = sides.iter().filter(|s| is_wall(s)).count();
    let open = (0..4).find(|&i| is_open(&sides[i])).filter(|_| walls == 3)?;
    let outward = HORIZONTAL[open];
    let bounds = scene.bounds();
    let half = 0.5 * bounds.extent();
    let reach = half.y.max(half.dot(outward.cross(Vec3::Y).abs()));
    let distance = half.dot(outward.abs()) + 1.02 * reach / (0.5 * BOX_FOV.to_radians()).tan();
    let size = bounds.diagonal();
    let eye = rounded(bounds.centre() + distance * outward, size);
    Some(CameraDescription { fov: BOX_FOV, ..CameraDescription::looking(eye, rounded(bounds.centre(), size)) })
}

/// A camera that just frames the bounds, from the front right and slightly above; the flatter the object, the more so.
pub(super) fn round_object(scene: &Scene) -> CameraDescription {
    let bounds = scene.bounds();
    let size = bounds.diagonal();
    let extent = bounds.extent();
    let flatness = (1.0 - extent.y / extent.max_element()).clamp(0.0, 1.0);
    let towards = Vec3::new(0.45, 0.4 + 0.6 * flatness, 1.0).normalize();
    let right = Vec3::Y.cross(towards).normalize();
    let up = towards.cross(right);
    let slope = (0.5 * OBJECT_FOV.to_radians()).tan();
    let distance = |corner: Vec3| {
        let p = corner - bounds.centre();
        p.dot(right).abs().max(p.dot(up).abs()) / slope + p.dot(towards)
    };
    let farthest = bounds.corners().into_iter().map(distance).fold(0.0, f32::max);
    let eye = rounded(bounds.centre() + 1.03 * farthest * towards, size);
    CameraDescription { fov: OBJECT_FOV, ..CameraDescription::looking(eye, rounded(bounds.centre(), size)) }
}
