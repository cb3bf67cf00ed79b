//! Reproducible random points and rays.

use glam::Vec3;
use tracer::Ray;
use tracer::scene::Bounds;

/// SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u32 << 24) as f32
    }

    /// In the cube [−1, 1)³.
    pub fn point(&mut self) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| 2.0 * self.unit() - 1.0))
    }

    /// A unit vector, every direction equally likely.
    fn direction(&mut self) -> Vec3 {
        loop {
            let point = self.point();
            if (0.01..1.0).contains(&point.length_squared()) {
                return point.normalize();
            }
        }
    }

    /// An endless ray from anywhere in the box to anywhere.
    pub fn ray(&mut self, bounds: Bounds) -> Ray {
        let origin = bounds.centre() + 0.5 * bounds.extent() * self.point();
        Ray { origin, direction: self.direction(), t_max: f32::INFINITY, time: 0.0 }
    }
}
