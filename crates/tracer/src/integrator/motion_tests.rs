//! Motion blur against the mean of many still pictures.

use glam::{DAffine3, DVec3, Vec3};
use stack::{ComponentRole, Size};

use super::test_scenes::{Pieces, diffuse, lamp, mean_of, peering, render};
use super::{DirectLight, TraceSettings};
use crate::camera::CameraDescription;
use crate::material::Material;
use crate::scene::{Instance, Mesh, Motion, Placement, Scene};

/// A sphere that tumbles past, a lamp that swings, a floor that stands.
fn fair() -> Scene {
    let swing = Motion { translate: DVec3::X, turn: DVec3::new(0.0, 0.0, 0.8), centre: DVec3::new(0.0, 3.0, 0.0) };
    let fall = Motion { translate: DVec3::new(0.9, -0.5, 0.0), turn: DVec3::new(0.0, 3.0, 1.0), centre: DVec3::ZERO };
    Pieces::default()
        .quad(Vec3::new(-4.0, -1.0, 4.0), Vec3::X * 8.0, -Vec3::Z * 8.0, (diffuse(0.7), 0.0))
        .quad(Vec3::new(-1.5, -0.5, 0.0), Vec3::X * 0.8, Vec3::Y * 0.8, (diffuse(0.4), 0.0))
        .moving(fall)
        .quad(Vec3::new(-0.5, 2.0, -0.5), Vec3::X, Vec3::Z, lamp(6.0))
        .moving(swing)
        .under(Some(0.2))
}

/// Means of a picture's quarters, and their variances, of light scattered or seen.
fn quarters(shutter: [f32; 2], spp: u32, settings: &TraceSettings) -> Vec<(f64, f64)> {
    let pan = Motion { translate: DVec3::new(0.3, 0.0, 0.0), turn: DVec3::Y * 0.1, centre: DVec3::new(0.0, 1.0, 6.0) };
    let camera = CameraDescription {
        shutter,
        motion: Some(pan),
        ..CameraDescription::looking(Vec3::new(0.0, 1.0, 6.0), Vec3::new(0.0, 0.5, 0.0))
    };
    let size = Size::new(16, 16);
    let (stack, _) = render(&fair(), &camera.on(size).unwrap(), spp, settings);
    let mut sums = vec![(0.0, 0.0); 4];
    for role in ComponentRole::ALL {
        let estimate = &stack.component(role).unwrap().radiance;
        let variance = estimate.variance_of_mean(&stack.samples).unwrap();
        for pixel in 0..size.pixels() {
            let quarter = &mut sums[pixel % 16 / 8 + 2 * (pixel / 128)];
            quarter.0 += f64::from(estimate.mean.channels()[0][pixel]) / 64.0;
            quarter.1 += f64::from(variance.channels()[0][pixel]) / (64.0 * 64.0);
        }
    }
    sums
}

#[test]
fn motion_blur_is_the_mean_of_still_pictures() {
    const STILLS: u32 = 32;
    for (direct_light, spp) in [(DirectLight::Both, 512), (DirectLight::Surfaces, 256)] {
        let settings = TraceSettings { direct_light, ..TraceSettings::DEFAULT };
        let blurred = quarters([0.2, 1.0], spp, &settings);
        let mut mean = vec![(0.0, 0.0); 4];
        for i in 0..STILLS {
            let time = 0.2 + 0.8 * (i as f32 + 0.5) / STILLS as f32;
            let seed = u64::from(i) + 1;
            let still = quarters([time, time], spp / 8, &TraceSettings { seed, ..settings });
            for (sum, (value, variance)) in mean.iter_mut().zip(still) {
                *sum = (sum.0 + value / f64::from(STILLS), sum.1 + variance / f64::from(STILLS * STILLS));
            }
        }
        for ((a, a_variance), (b, b_variance)) in blurred.into_iter().zip(mean) {
            let error = 4.0 * (a_variance + b_variance).sqrt();
            assert!((a - b).abs() < error && error < 0.08 * b, "{direct_light:?}: {a} {b} ± {error}");
        }
    }
}

/// A lamp far from its mesh's own origin, whose corners round differently wherever it moves, must not shadow itself: it
/// moves so little that its light is that of one that stands.
#[test]
fn moving_lamps_do_not_shadow_themselves() {
    let quad = |corner: Vec3, a: Vec3, b: Vec3, material: u32| Mesh {
        positions: vec![corner, corner + a, corner + a + b, corner + b],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        materials: vec![material; 2],
        ..Mesh::default()
    };
    let far = Vec3::new(0.3, 300.7, 0.7);
    let floor = quad(Vec3::new(-5.0, 0.0, 5.0), Vec3::X * 10.0, -Vec3::Z * 10.0, 0);
    let lit = quad(far - Vec3::new(0.5, 0.0, 0.5), Vec3::X, Vec3::Z, 1);
    let back = DVec3::Y * 1.5 - far.as_dvec3();
    let stand = |mesh, map, motion| Instance { mesh, placement: Placement::new(map).unwrap(), motion };
    let materials = [diffuse(0.5), diffuse(0.0)].into_iter().zip([0.0, 3.0]);
    let scene = |motion| {
        let materials = materials.clone().map(|(surface, light)| Material::new("", surface, Vec3::splat(light)));
        let stands = vec![stand(0, DAffine3::IDENTITY, None), stand(1, DAffine3::from_translation(back), motion)];
        Scene::new(vec![floor.clone(), lit.clone()], stands, materials.collect(), None).unwrap()
    };
    let camera = peering(Vec3::new(3.0, 1.0, 0.0), Vec3::ZERO);
    let motion = Motion { translate: DVec3::Y * 0.001, turn: DVec3::ZERO, centre: DVec3::ZERO };
    let scattered = |motion| {
        let (stack, _) = render(&scene(motion), &camera, 64, &TraceSettings::DEFAULT);
        mean_of(&stack, ComponentRole::Scattered).0
    };
    let (still, moving) = (scattered(None), scattered(Some(motion)));
    assert!((moving / still - 1.0).abs() < 0.01, "{moving} {still}");
}
