//! Maps from the unit square to other domains, with their densities.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::{Vec2, Vec3};

/// A point of the unit disc, uniform over its area; concentric map (Shirley and Chiu 1997), which keeps strata in one
/// piece.
#[inline]
pub fn sample_disc(u: Vec2) -> Vec2 {
    let p = 2.0 * u - Vec2::ONE;
    if p == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, angle) =
        if p.x.abs() > p.y.abs() { (p.x, PI / 4.0 * (p.y / p.x)) } else { (p.y, PI / 2.0 - PI / 4.0 * (p.x / p.y)) };
    radius * Vec2::new(angle.cos(), angle.sin())
}

/// A direction of the hemisphere around +z, in proportion to its cosine (Malley's method).
#[inline]
pub fn sample_cosine_hemisphere(u: Vec2) -> Vec3 {
    let d = sample_disc(u);
    Vec3::new(d.x, d.y, (1.0 - d.length_squared()).max(0.0).sqrt())
}

/// Density of [`sample_cosine_hemisphere`] per solid angle, for a direction with cosine `cosine`.
#[inline]
pub fn cosine_hemisphere_pdf(cosine: f32) -> f32 {
    cosine.max(0.0) * FRAC_1_PI
}

/// A direction of the cap round +z that is `height` high (1 − the cosine of its half-angle, 0 … 2), uniform over solid
/// angle.
#[inline]
pub fn sample_cap(height: f32, u: Vec2) -> Vec3 {
    let below = height * u.x;
    let across = Vec2::from_angle(TAU * u.y) * (below * (2.0 - below)).max(0.0).sqrt();
    across.extend(1.0 - below)
}

/// A direction of the sphere, uniform over solid angle.
#[inline]
pub fn sample_sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (TAU * u.y).sin_cos();
    Vec3::new(radius * cos, radius * sin, z)
}

/// Barycentric coordinates (of the three corners) of a point of a triangle, uniform over its area; low-distortion map
/// (Heitz 2019).
#[inline]
pub fn sample_triangle(u: Vec2) -> [f32; 3] {
    let (b0, b1) = if u.x < u.y {
        let b0 = u.x / 2.0;
        (b0, u.y - b0)
    } else {
        let b1 = u.y / 2.0;
        (u.x - b1, b1)
    };
    [b0, b1, 1.0 - b0 - b1]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Midpoints of a fine grid on the unit square.
    fn grid() -> impl Iterator<Item = Vec2> {
        const N: usize = 200;
        (0..N * N).map(|i| (Vec2::new((i % N) as f32, (i / N) as f32) + 0.5) / N as f32)
    }

    fn mean(f: impl Fn(Vec2) -> f32) -> f32 {
        (grid().map(|u| f64::from(f(u))).sum::<f64>() / grid().count() as f64) as f32
    }

    #[test]
    fn disc_moments_are_those_of_a_uniform_disc() {
        assert!(mean(|u| sample_disc(u).x).abs() < 1e-4);
        assert!((mean(|u| sample_disc(u).x.powi(2)) - 0.25).abs() < 1e-4);
        assert!((mean(|u| sample_disc(u).length_squared().powi(2)) - 1.0 / 3.0).abs() < 1e-4);
        assert!(grid().all(|u| sample_disc(u).length() <= 1.000_001));
        assert_eq!(sample_disc(Vec2::splat(0.5)), Vec2::ZERO);
    }

    #[test]
    fn hemisphere_moments_are_those_of_a_cosine() {
        assert!((mean(|u| sample_cosine_hemisphere(u).z) - 2.0 / 3.0).abs() < 1e-3);
        assert!((mean(|u| sample_cosine_hemisphere(u).z.powi(2)) - 0.5).abs() < 1e-4);
        assert!((mean(|u| sample_cosine_hemisphere(u).y.powi(2)) - 0.25).abs() < 1e-4);
    }

    #[test]
    fn cap_moments_are_those_of_its_slice() {
        // Along z a sphere is even (Archimedes): between 1 − h and 1.
        for height in [0.01, 0.5, 2.0] {
            assert!((mean(|u| sample_cap(height, u).z) - (1.0 - 0.5 * height)).abs() < 1e-5);
            assert!(mean(|u| sample_cap(height, u).x).abs() < 1e-4);
            assert!(grid().all(|u| (sample_cap(height, u).length() - 1.0).abs() < 1e-5));
        }
    }

    #[test]
    fn sphere_moments_are_uniform() {
        for axis in 0..3 {
            assert!(mean(|u| sample_sphere(u)[axis]).abs() < 1e-4);
            assert!((mean(|u| sample_sphere(u)[axis].powi(2)) - 1.0 / 3.0).abs() < 1e-4);
        }
    }

    #[test]
    fn triangle_moments_are_uniform() {
        for corner in 0..3 {
            assert!((mean(|u| sample_triangle(u)[corner]) - 1.0 / 3.0).abs() < 1e-4);
            assert!((mean(|u| sample_triangle(u)[corner].powi(2)) - 1.0 / 6.0).abs() < 1e-4);
        }
    }

    #[test]
    fn a_grid_on_the_square_has_the_moments_of_a_uniform_disk() {
        let n = 200;
        let (mut mean, mut square, mut fourth) = (Vec2::ZERO, Vec2::ZERO, 0.0f32);
        for k in 0..n * n {
            let cell = Vec2::new((k % n) as f32 + 0.5, (k / n) as f32 + 0.5) / n as f32;
            let p = sample_disc(cell);
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
        assert_eq!(sample_disc(Vec2::splat(0.5)), Vec2::ZERO);
    }
}
