//! A point on a surface that a ray has found.

use glam::Vec3;

use crate::Ray;
use crate::material::{Material, Surface};
use crate::texture::TexCoords;

/// A point on a surface, with all that scattering needs to know about it.
#[derive(Clone, Copy, Debug)]
pub struct Interaction<'a> {
    /// Where, in scene units.
    pub position: Vec3,
    /// Bound of the absolute rounding error of `position`, per axis (pbrt-v4, section 6.8).
    pub position_error: Vec3,
    /// Unit normal of the triangle, on the side its winding (counter-clockwise seen from outside) says.
    pub geometric_normal: Vec3,
    /// Interpolated unit normal, in the hemisphere of `geometric_normal`.
    pub shading_normal: Vec3,
    /// Unit normal of its clear coat, in the same hemisphere; that of the surface where it has none.
    pub coat_normal: Vec3,
    /// Texture coordinates; zero where the mesh has none.
    pub uv: TexCoords,
    /// Colour of the vertices, which multiplies that of the surface; white where the mesh has none.
    pub tint: Vec3,
    /// Unit direction back along the ray.
    pub outgoing: Vec3,
    /// Distance along the ray.
    pub distance: f32,
    /// Moment within the frame, 0 … 1.
    pub time: f32,
    /// Index of the triangle among the scene's emitters, when it emits.
    pub emitter: Option<u32>,
    /// What it is made of.
    pub material: &'a Material,
}

impl<'a> Interaction<'a> {
    /// A point that is where it is without error, on an even surface of unit normal `normal` without colours of vertices, seen
    /// from along the normal.
    pub(crate) fn facing(position: Vec3, normal: Vec3, material: &'a Material) -> Self {
        Self {
            position,
            position_error: Vec3::ZERO,
            geometric_normal: normal,
            shading_normal: normal,
            coat_normal: normal,
            uv: TexCoords::ZERO,
            tint: Vec3::ONE,
            outgoing: normal,
            distance: 0.0,
            time: 0.0,
            emitter: None,
            material,
        }
    }

    /// What light loses by unit length along `direction`, which goes on from here, where it loses `here` on the viewer's side.
    /// Only glass that is no pane has another side; beyond its outside is air, whatever lies round it.
    #[inline]
    pub(crate) fn absorption_towards(&self, direction: Vec3, here: Vec3) -> Vec3 {
        match &self.material.surface {
            Surface::Glass { .. } if self.geometric_normal.dot(direction) < 0.0 => self.material.maps.absorption,
            Surface::Glass { .. } => Vec3::ZERO,
            _ => here,
        }
    }

    /// The triangle's unit normal, on the viewer's side.
    #[inline]
    pub(crate) fn facing_normal(&self) -> Vec3 {
        if self.geometric_normal.dot(self.outgoing) < 0.0 { -self.geometric_normal } else { self.geometric_normal }
    }

    /// A ray that leaves this point in the unit direction `direction`, moved off the surface by no more than the
    /// rounding error demands.
    #[inline]
    pub fn spawn(&self, direction: Vec3) -> Ray {
        let origin = offset_origin(self.position, self.position_error, self.geometric_normal, direction);
        Ray { origin, direction, t_max: f32::INFINITY, time: self.time }
    }

    /// A ray from here that ends just before `target`, for visibility; `target_error` as `position_error`.
    ///
    /// The error of the segment itself (its direction and length are rounded) is added to the target's, so that the
    /// surface round the target does not hide it at any angle. When both points coincide, `t_max` is zero.
    pub fn spawn_to(&self, target: Vec3, target_normal: Vec3, target_error: Vec3) -> Ray {
        let origin = offset_origin(self.position, self.position_error, self.geometric_normal, target - self.position);
        let reach = (target - origin).abs().max_element() + target.abs().max_element();
        let error = 2.0 * target_error + Vec3::splat(SEGMENT_STEPS * 0.5 * f32::EPSILON * reach);
        let span = offset_origin(target, error, target_normal, origin - target) - origin;
        let distance = span.length();
        let direction = if distance > 0.0 { span / distance } else { target_normal };
        Ray { origin, direction, t_max: distance, time: self.time }
    }
}

/// Share of light that is left after the way `length`, of which every unit takes `absorption` (Beer and Lambert). What has no
/// end takes nothing: the sky is not within glass, so the mesh is open.
#[inline]
pub(crate) fn left_after(length: f32, absorption: Vec3) -> Vec3 {
    if absorption == Vec3::ZERO || length.is_infinite() { Vec3::ONE } else { (-length * absorption).exp() }
}

/// Rounded operations behind direction and length of a segment between two points, with those of the triangle test.
const SEGMENT_STEPS: f32 = 16.0;

/// `point` moved along `normal` to the side `direction` points to, out of its box of rounding errors (pbrt-v4,
/// section 6.8.6, `OffsetRayOrigin`).
#[inline]
fn offset_origin(point: Vec3, error: Vec3, normal: Vec3, direction: Vec3) -> Vec3 {
    let distance = normal.abs().dot(error);
    let offset = if direction.dot(normal) < 0.0 { -distance * normal } else { distance * normal };
    let moved = point + offset;
    Vec3::from_array(std::array::from_fn(|axis| {
        if offset[axis] > 0.0 {
            moved[axis].next_up()
        } else if offset[axis] < 0.0 {
            moved[axis].next_down()
        } else {
            moved[axis]
        }
    }))
}
