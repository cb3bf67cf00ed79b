//! A ray prepared for box tests.

use glam::Vec3;

use super::Bounds;
use crate::Ray;

/// A ray prepared for tests against boxes inside known bounds.
///
/// Boxes are widened by moving the origin away from the entry planes and towards the exit planes. The pad covers the
/// rounding error of the slab test and of the triangle test (Woop, Benthin, Wald 2013, section 3.3), both proportional
/// to the greatest distance from the origin to anything in the bounds, so every triangle the ray is found to hit lies
/// in boxes it is found to hit.
#[derive(Clone, Debug)]
pub struct SlabRay {
    pub(super) entry_origin: [f32; 3],
    pub(super) exit_origin: [f32; 3],
    /// 1 / direction; ±∞ for a zero component.
    pub(super) inverse: [f32; 3],
    /// 1 where the direction is negative, else 0.
    pub(super) negative: [usize; 3],
    /// Whether origin and direction are numbers; a ray that is not meets nothing.
    pub(super) sound: bool,
}

impl SlabRay {
    /// Rounding steps covered: 3 of the slab test, 5 of the sheared triangle test on each side, doubled.
    const STEPS: f32 = 16.0;

    /// Prepares a ray for boxes inside `bounds`, padded by `extra` on top.
    pub fn new(ray: &Ray, bounds: &Bounds, extra: f32) -> Self {
        let reach = (bounds.min - ray.origin).abs().max((bounds.max - ray.origin).abs()).max_element();
        // Far from zero the pad itself would be rounded away when added to the origin.
        let rounding = f32::EPSILON * ray.origin.abs().max_element();
        Self::padded(ray.origin, ray.direction, Self::STEPS * 0.5 * f32::EPSILON * reach + rounding + extra)
    }

    /// Prepares a ray for boxes padded by `pad`, in their units.
    fn padded(origin: Vec3, direction: Vec3, pad: f32) -> Self {
        let negative: [bool; 3] = std::array::from_fn(|axis| direction[axis].is_sign_negative());
        let away = |sign: f32| std::array::from_fn(|a| origin[a] + if negative[a] { -sign * pad } else { sign * pad });
        Self {
            entry_origin: away(1.0),
            exit_origin: away(-1.0),
            inverse: direction.recip().to_array(),
            negative: negative.map(usize::from),
            sound: origin.is_finite() && direction.is_finite(),
        }
    }
}
