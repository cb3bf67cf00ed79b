//! Points on the lens.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::Vec2;

/// Maps the unit square to the unit disk, equal areas to equal areas (Shirley and Chiu 1997).
pub(super) fn concentric_disk(square: Vec2) -> Vec2 {
    let p = 2.0 * square - Vec2::ONE;
    if p == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, angle) =
        if p.x.abs() > p.y.abs() { (p.x, FRAC_PI_4 * (p.y / p.x)) } else { (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y)) };
    radius * Vec2::from_angle(angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_on_the_square_has_the_moments_of_a_uniform_disk() {
        let n = 200;
        let (mut mean, mut square, mut fourth) = (Vec2::ZERO, Vec2::ZERO, 0.0f32);
        for k in 0..n * n {
            let cell = Vec2::new((k % n) as f32 + 0.5, (k / n) as f32 + 0.5) / n as f32;
            let p = concentric_disk(cell);
            assert!(p.length() <= 1.0 + 1e-6);
            mean += p / (n * n) as f32;
            square += p * p / (n * n) as f32;
            fourth += p.length_squared().powi(2) / (n * n) as f32;
        }
        // Over the uniform unit disk E x² = E y² = 1/4 and E r⁴ = 1/3.
        assert!(mean.length() < 1e-4 && (square - Vec2::splat(0.25)).length() < 1e-3);
        assert!((fourth - 1.0 / 3.0).abs() < 1e-3);
    }

    #[test]
    fn the_middle_of_the_square_is_the_centre_of_the_lens() {
        assert_eq!(concentric_disk(Vec2::splat(0.5)), Vec2::ZERO);
    }
}
