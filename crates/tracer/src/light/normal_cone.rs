//! Cones that hold directions.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DQuat, DVec3, Vec3};

/// All directions within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NormalCone {
    /// Unit vector.
    axis: DVec3,
    /// Radians, 0 … π.
    spread: f64,
    cos_spread: f64,
}

impl NormalCone {
    /// The cone of `spread` radians round the unit vector `axis`.
    pub(super) fn new(axis: Vec3, spread: f64) -> Self {
        Self::round(axis.as_dvec3(), spread.min(PI))
    }

    fn round(axis: DVec3, spread: f64) -> Self {
        Self { axis, spread, cos_spread: spread.cos() }
    }

    /// Its axis, a unit vector.
    pub(super) fn axis(&self) -> Vec3 {
        self.axis.as_vec3()
    }

    /// The angle between its axis and its surface, 0 … π.
    pub(super) fn spread(&self) -> f64 {
        self.spread
    }

    /// A cone that holds both, as narrow as cones of one axis between theirs can be.
    pub(super) fn union(self, other: Self) -> Self {
        if other.spread == 0.0 && self.axis.dot(other.axis) >= self.cos_spread {
            return self;
        }
        let between = self.axis.angle_between(other.axis);
        if between + other.spread <= self.spread {
            return self;
        }
        if between + self.spread <= other.spread {
            return other;
        }
        let spread = 0.5 * (self.spread + between + other.spread);
        match self.axis.cross(other.axis).try_normalize() {
            Some(across) if spread < PI => {
                let turn = DQuat::from_axis_angle(across, spread - self.spread);
                Self::round((turn * self.axis).normalize(), spread)
            }
            // Parallel axes, which rounding alone keeps apart; else opposite ones.
            None if between < FRAC_PI_2 => Self::round(self.axis, self.spread.max(other.spread)),
            _ => Self::round(self.axis, PI),
        }
    }

    /// Directions into which surfaces with these normals emit, each weighted by how much: M_Ω of Conty Estevez and Kulla
    /// (2018), equation 1, for emission into the whole hemisphere round every normal.
    pub(super) fn measure(&self) -> f64 {
        let (sin, cos) = self.spread.sin_cos();
        let widest = (self.spread + FRAC_PI_2).min(PI);
        TAU * (1.0 - cos)
            + FRAC_PI_2 * (2.0 * widest * sin - (self.spread - 2.0 * widest).cos() - 2.0 * self.spread * sin + cos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::random::Random;

    #[test]
    fn a_union_holds_both_and_is_no_wider_than_it_must_be() {
        let mut random = Random(3);
        let cone = |random: &mut Random| NormalCone::new(random.direction(), 1.2 * f64::from(random.unit()));
        for _ in 0..2_000 {
            let (a, b) = (cone(&mut random), cone(&mut random));
            let both = a.union(b);
            for part in [a, b] {
                let reach = both.axis.angle_between(part.axis) + part.spread;
                assert!(reach <= both.spread + 1e-6, "{a:?} {b:?} {both:?}");
            }
            let needed = 0.5 * (a.spread + b.spread + a.axis.angle_between(b.axis));
            assert!(both.spread <= needed.max(a.spread).max(b.spread) + 1e-6);
        }
        let up = NormalCone::new(Vec3::Y, 0.1);
        assert_eq!(up.union(NormalCone::new(-Vec3::Y, 0.0)).spread, PI);
        assert_eq!(up.union(up), up);
    }

    /// ∫ max(0, cos) over the sphere is π for one normal, and everything is reached from all normals.
    #[test]
    fn the_measure_grows_from_half_space_to_all_of_it() {
        let measure = |spread| NormalCone::new(Vec3::Y, spread).measure();
        assert!((measure(0.0) - PI).abs() < 1e-12);
        assert!((measure(PI) - 2.0 * TAU).abs() < 1e-12);
        assert!((0..100).all(|i| measure(PI * f64::from(i) / 100.0) < measure(PI * f64::from(i + 1) / 100.0)));
    }
}
