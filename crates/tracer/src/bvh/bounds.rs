//! Axis-aligned boxes.

use glam::Vec3;

/// An axis-aligned box; empty when a `min` exceeds its `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least coordinates.
    pub min: Vec3,
    /// Greatest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box round `points`.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The smallest box round both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether it holds nothing.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// The middle.
    pub fn centre(&self) -> Vec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// Edge lengths.
    pub fn extent(&self) -> Vec3 {
        self.max - self.min
    }

    /// Distance between opposite corners.
    pub fn diagonal(&self) -> f32 {
        self.extent().as_dvec3().length() as f32
    }

    /// Radius of the sphere through the corners, round [`centre`](Self::centre).
    pub fn radius(&self) -> f32 {
        0.5 * self.diagonal()
    }

    /// The eight corners.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, axis: usize| if i >> bit & 1 == 0 { self.min[axis] } else { self.max[axis] };
            Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
        })
    }

    /// Half the surface, relative to `unit`, in f64 so that it neither overflows nor vanishes.
    pub(super) fn half_area(&self, unit: f64) -> f64 {
        let e = self.extent().as_dvec3() / unit;
        e.x * e.y + e.y * e.z + e.z * e.x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_round_points_has_their_extremes() {
        let b = Bounds::of([Vec3::new(1.0, -2.0, 3.0), Vec3::new(-1.0, 4.0, 3.5)]);
        assert_eq!(b, Bounds { min: Vec3::new(-1.0, -2.0, 3.0), max: Vec3::new(1.0, 4.0, 3.5) });
        assert_eq!(b.centre(), Vec3::new(0.0, 1.0, 3.25));
        assert_eq!(b.diagonal(), (4.0f32 + 36.0 + 0.25).sqrt());
        assert_eq!(Bounds::of(b.corners()), b);
        assert!(Bounds::EMPTY.is_empty() && !b.is_empty());
        assert_eq!(b.union(Bounds::EMPTY), b);
    }
}
