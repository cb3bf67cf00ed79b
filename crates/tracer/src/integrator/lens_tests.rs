//! A thin lens against the mean of pinholes spread over it.

use glam::Vec3;
use stack::{ComponentRole, Size};

use super::TraceSettings;
use super::test_scenes::{Pieces, diffuse, lamp, render};
use crate::camera::{Camera, CameraDescription};
use crate::scene::Scene;

const SIDE: usize = 16;
/// Distance of the plane in focus.
const FOCUS: f32 = 5.0;
/// Radius of the lens, in widths of a pixel in the plane of focus.
const RADIUS: i32 = 6;
/// Width of a pixel in the plane of focus.
const PITCH: f32 = 2.0 * FOCUS * HALF_HEIGHT / SIDE as f32;
/// Tangent of half the field of view.
const HALF_HEIGHT: f32 = 0.4;

/// A card before the plane of focus, a glowing one behind it, a wall far behind.
fn cards() -> Scene {
    Pieces::default()
        .quad(Vec3::new(-9.0, -9.0, -6.0), Vec3::X * 18.0, Vec3::Y * 18.0, (diffuse(0.3), 0.0))
        .quad(Vec3::new(-2.0, -0.4, 2.5), Vec3::X * 1.8, Vec3::Y * 0.9, (diffuse(0.8), 0.0))
        .quad(Vec3::new(0.3, 0.2, -2.0), Vec3::X * 0.8, Vec3::Y, lamp(2.0))
        .under(Some(0.5))
}

/// A camera at (`x`, `y`, 5) that looks along −z, with `side` pixels of the same width whatever their number.
fn camera(x: f32, y: f32, side: usize, lens_radius: f32) -> Camera {
    let eye = Vec3::new(x, y, FOCUS);
    let half_height = HALF_HEIGHT * side as f32 / SIDE as f32;
    let fov = 2.0 * half_height.atan().to_degrees();
    let focus_distance = Some(FOCUS);
    let description = CameraDescription {
        fov,
        lens_radius,
        focus_distance,
        ..CameraDescription::looking(eye, eye - FOCUS * Vec3::Z)
    };
    description.on(Size::new(side, side)).unwrap()
}

/// Value and variance of every pixel.
fn picture(camera: &Camera, spp: u32, seed: u64) -> Vec<(f64, f64)> {
    let (stack, _) = render(&cards(), camera, spp, &TraceSettings { seed, ..TraceSettings::DEFAULT });
    let mut pixels = vec![(0.0, 0.0); camera.film.pixels()];
    for role in ComponentRole::ALL {
        let estimate = &stack.component(role).unwrap().radiance;
        let variance = estimate.variance_of_mean(&stack.samples).unwrap();
        for (i, pixel) in pixels.iter_mut().enumerate() {
            pixel.0 += f64::from(estimate.mean.channels()[0][i]);
            pixel.1 += f64::from(variance.channels()[0][i]);
        }
    }
    pixels
}

/// Seen from a point of the lens that is k pixels of the plane of focus off its centre, that plane is shifted by k pixels.
#[test]
fn a_thin_lens_shows_the_mean_of_pinholes_spread_over_it() {
    let lens = picture(&camera(0.0, 0.0, SIDE, RADIUS as f32 * PITCH), 1024, 1);
    let wide = SIDE + 2 * RADIUS as usize;
    let mut mean = vec![(0.0, 0.0); SIDE * SIDE];
    let mut pinholes = 0.0;
    for (kx, ky) in (-RADIUS..=RADIUS).flat_map(|x| (-RADIUS..=RADIUS).map(move |y| (x, y))) {
        if kx * kx + ky * ky > RADIUS * RADIUS {
            continue;
        }
        let shifted = picture(&camera(kx as f32 * PITCH, ky as f32 * PITCH, wide, 0.0), 16, 2);
        pinholes += 1.0;
        for (i, sum) in mean.iter_mut().enumerate() {
            let column = (i % SIDE) as i32 + RADIUS - kx;
            let row = (i / SIDE) as i32 + RADIUS + ky;
            let (value, variance) = shifted[row as usize * wide + column as usize];
            *sum = (sum.0 + value, sum.1 + variance);
        }
    }
    // Value and variance of the mean of a block of 4 × 4 pixels.
    let block = |pixels: &[(f64, f64)], of: usize| {
        let inside = |i: &usize| i % SIDE / 4 + 4 * (i / SIDE / 4) == of;
        let sum = |f: fn(&(f64, f64)) -> f64| (0..SIDE * SIDE).filter(inside).map(|i| f(&pixels[i])).sum::<f64>();
        (sum(|p| p.0) / 16.0, sum(|p| p.1) / 256.0)
    };
    let sharp = picture(&camera(0.0, 0.0, SIDE, 0.0), 64, 3);
    let mut blurred = 0;
    for of in 0..16 {
        let ((a, a_variance), (b, b_variance)) = (block(&lens, of), block(&mean, of));
        let (b, b_variance) = (b / pinholes, b_variance / (pinholes * pinholes));
        // The lattice of pinholes stands for the disc to about this share.
        let error = 4.0 * (a_variance + b_variance).sqrt() + 0.01 * b;
        assert!((a - b).abs() < error && error < 0.08 * b, "{of}: {a} {b} ± {error}");
        // Some blocks show that the lens matters.
        blurred += u32::from((block(&sharp, of).0 - a).abs() > 0.1 * a);
    }
    assert!(blurred >= 3, "{blurred}");
}
