//! A ray.

use glam::Vec3;

/// A half-line segment at one moment of the shutter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts, in scene units.
    pub origin: Vec3,
    /// Where it goes; unit length.
    pub direction: Vec3,
    /// Hits at or beyond this distance do not count; infinite for a camera ray.
    pub t_max: f32,
    /// Moment within the frame, 0 … 1; the camera's shutter is open for a part of it or all.
    pub time: f32,
}

impl Ray {
    /// The point at distance `t`.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.direction
    }
}
