//! A point on a surface that a ray has found.

use glam::{Vec2, Vec3};

use crate::Ray;
use crate::material::Material;

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
    /// Texture coordinates; zero where the mesh has none.
    pub uv: Vec2,
    /// Unit direction back along the ray.
    pub outgoing: Vec3,
    /// Distance along the ray.
    pub distance: f32,
    /// Moment of the shutter, 0 … 1.
    pub time: f32,
    /// Index of the triangle among the scene's emitters, when it emits.
    pub emitter: Option<u32>,
    /// What it is made of.
    pub material: &'a Material,
}

impl Interaction<'_> {
    /// A ray that leaves this point in the unit direction `direction`, moved off the surface by no more than the
    /// rounding error demands.
    pub fn spawn(&self, direction: Vec3) -> Ray {
        let _ = direction;
        todo!("scene helper")
    }

    /// A ray from here that ends just before `target`, for visibility; `target_error` as `position_error`.
    pub fn spawn_to(&self, target: Vec3, target_normal: Vec3, target_error: Vec3) -> Ray {
        let _ = (target, target_normal, target_error);
        todo!("scene helper")
    }
}
