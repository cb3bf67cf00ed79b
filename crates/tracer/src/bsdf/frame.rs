//! Local frames.

use glam::Vec3;

/// An orthonormal frame around a normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    tangent: Vec3,
    bitangent: Vec3,
    normal: Vec3,
}

impl Frame {
    /// A frame whose +z is the unit vector `normal` (Duff et al. 2017, *Building an Orthonormal Basis, Revisited*).
    #[inline]
    pub(crate) fn new(normal: Vec3) -> Self {
        let sign = 1.0_f32.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            tangent: Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            bitangent: Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    /// The world vector `v` in this frame.
    #[inline]
    pub(crate) fn to_local(self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.tangent), v.dot(self.bitangent), v.dot(self.normal))
    }

    /// The vector `v` of this frame in the world.
    #[inline]
    pub(crate) fn to_world(self, v: Vec3) -> Vec3 {
        v.x * self.tangent + v.y * self.bitangent + v.z * self.normal
    }
}

/// `direction` of a frame with a z above zero, which rounding may have taken from it.
#[inline]
pub(super) fn above(direction: Vec3) -> Vec3 {
    Vec3::new(direction.x, direction.y, direction.z.max(1e-7))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_orthonormal_and_turns_back() {
        for normal in [Vec3::Z, -Vec3::Z, Vec3::X, Vec3::new(0.6, 0.0, -0.8), Vec3::new(1e-4, 0.0, -1.0).normalize()] {
            let frame = Frame::new(normal);
            assert!((frame.tangent.cross(frame.bitangent) - normal).length() < 1e-6);
            let v = Vec3::new(0.3, -2.0, 0.7);
            assert!((frame.to_world(frame.to_local(v)) - v).length() < 1e-6);
            assert!((frame.to_local(normal) - Vec3::Z).length() < 1e-6);
        }
    }
}
