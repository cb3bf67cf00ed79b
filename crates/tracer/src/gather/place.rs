//! Places in the scene, and cells of space.

use glam::Vec3;

/// Binary digits of a place along each axis.
pub(super) const DIGITS: u32 = 20;

/// A place in the scene, the way its surface faces, and whether that is coated: 3 × 20 digits of its coordinates, 3 of the
/// axis and 1. In two words, so that a point takes no more than it must: there are several for each pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place([u32; 2]);

impl Place {
    /// Coordinates in steps from the scene's corner.
    pub(super) fn new(position: Vec3, normal: Vec3, is_coated: bool) -> Self {
        let axis = normal.abs().max_position();
        let facing = (u64::from(is_coated) << 3) | (2 * axis as u64 + u64::from(normal[axis] < 0.0));
        let last = ((1 << DIGITS) - 1) as f32;
        let digits = position.to_array().map(|x| x.clamp(0.0, last) as u64);
        let all = digits.into_iter().fold(facing, |all, digits| (all << DIGITS) | digits);
        Self([(all >> 32) as u32, all as u32])
    }

    /// The cell it lies in: its digits without the last `size` of each axis.
    pub(super) const fn cell(self, size: u32) -> u64 {
        let kept = ((1 << DIGITS) - 1) >> size << size;
        let axes = kept | kept << DIGITS | kept << (2 * DIGITS);
        let [high, low] = self.0;
        ((high as u64) << 32 | low as u64) & (axes | 0b1111 << (3 * DIGITS))
    }

    /// Whether the surface is coated.
    pub(super) const fn is_coated(self) -> bool {
        self.0[0] >> 31 == 1
    }
}
