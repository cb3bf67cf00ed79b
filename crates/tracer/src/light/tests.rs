use std::f32::consts::FRAC_1_PI;

use super::*;
use crate::bsdf::chi_square::{Random, integral, p_value};
use crate::environment::Environment;
use crate::material::{Colour, Material, Surface};
use crate::scene::{Instance, Mesh, Placement};

/// A lamp of `size` × `size` at height `height` over the origin, shining down, and an unlit triangle far below.
fn scene(size: f32, height: f32, sky: Option<Vec3>) -> Scene {
    let dull = Surface::Diffuse { reflectance: Colour::constant(Vec3::ZERO) };
    let material = |emission| Material::new("m", dull.clone(), emission);
    let h = 0.5 * size;
    let corner = |x: f32, z: f32| Vec3::new(x, height, z);
    let far = Vec3::new(0.0, -50.0, 0.0);
    let mesh = Mesh {
        positions: vec![corner(-h, -h), corner(h, -h), corner(h, h), corner(-h, h), far, far + Vec3::X, far + Vec3::Z],
        triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6]],
        materials: vec![0, 0, 1],
        ..Mesh::default()
    };
    let stand = Instance { mesh: 0, placement: Placement::IDENTITY, motion: None };
    Scene::new(
        vec![mesh],
        vec![stand],
        vec![material(Vec3::splat(2.0)), material(Vec3::ZERO)],
        sky.map(Environment::constant),
    )
    .unwrap()
}

/// A floor's way of looking for light.
const UP: Receiver = Receiver { position: FLOOR_POINT, normal: Vec3::Y, two_sided: false };

const FLOOR_POINT: Vec3 = Vec3::new(0.1, 0.0, -0.2);

/// A point of a floor facing up.
pub(super) fn floor_point(material: &Material) -> Interaction<'_> {
    Interaction { distance: 1.0, ..Interaction::facing(FLOOR_POINT, Vec3::Y, material) }
}

/// Density of all lights together in `direction`, found by following a ray.
fn pdf_along(lights: &Lights, from: &Interaction, direction: Vec3) -> f32 {
    let seen = lights.scene.intersect(&from.spawn(direction));
    let lamp = seen.and_then(|seen| Some(lights.light_pdf(UP, seen.emitter?, &seen)));
    lamp.unwrap_or(0.0) + lights.sky_pdf(UP, direction)
}

#[test]
fn densities_integrate_to_one_over_the_sphere() {
    for (sky, expected_sky) in [(None, 0.0), (Some(Vec3::splat(5e-4)), 0.19), (Some(Vec3::ONE), 0.5)] {
        let scene = scene(3.0, 1.0, sky);
        let lights = Lights::new(&scene);
        let from = floor_point(&scene.materials[1]);
        let total = integral(|direction| pdf_along(&lights, &from, direction));
        assert!((total - 1.0).abs() < 5e-3, "{sky:?}: {total}");
        assert!((lights.sky_share() - expected_sky).abs() < 0.1 * expected_sky + 1e-9, "{}", lights.sky_share());
    }
}

#[test]
fn a_veil_looks_for_the_sky_on_both_sides() {
    let scene = scene(3.0, 1.0, Some(Vec3::ONE));
    let mut dark = scene;
    dark.emitters.clear();
    let lights = Lights::new(&dark);
    let both = Receiver { two_sided: true, ..UP };
    let total = integral(|direction| lights.sky_pdf(both, direction));
    assert!((total - 1.0).abs() < 1e-3, "{total}");
    let from = floor_point(&dark.materials[1]);
    let p = p_value(
        |direction| lights.sky_pdf(both, direction),
        |random| lights.sample_light(&from, both, 0, random.point()).map(|sample| sample.direction),
    );
    assert!(p > 1e-4, "{p}");
}

#[test]
fn a_sample_carries_the_density_that_following_its_direction_finds() {
    let scene = scene(3.0, 1.0, Some(Vec3::splat(1e-3)));
    let lights = Lights::new(&scene);
    let from = floor_point(&scene.materials[1]);
    let mut random = Random(1);
    let (mut from_sky, mut from_lamp) = (0, 0);
    for i in 0..1000_u32 {
        let sample = lights.sample_light(&from, UP, i << 22, random.point()).unwrap();
        let lamp = sample.shadow_ray.t_max.is_finite();
        *(if lamp { &mut from_lamp } else { &mut from_sky }) += 1;
        let seen = scene.intersect(&from.spawn(sample.direction));
        let own = match (lamp, seen) {
            (false, _) => lights.sky_pdf(UP, sample.direction),
            (true, Some(seen)) => lights.light_pdf(UP, seen.emitter.unwrap(), &seen),
            (true, None) => panic!("the lamp is missed"),
        };
        assert!((sample.pdf / own - 1.0).abs() < 1e-3, "{} {own}", sample.pdf);
        assert!(lamp || !scene.occluded(&sample.shadow_ray) || seen.is_some());
    }
    assert!(from_sky > 300 && from_lamp > 300);
}

/// Irradiance below a corner of an a × b rectangle at distance c (Howell's catalogue, configuration B-3), as the
/// form factor of the point to the rectangle.
fn corner_form_factor(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / p * (y / p).atan() + y / q * (x / q).atan()) / std::f64::consts::TAU
}

#[test]
fn sampled_irradiance_is_the_form_factor_of_a_rectangle() {
    for (size, height) in [(3.0_f32, 1.0_f32), (0.5, 2.0)] {
        let scene = scene(size, height, None);
        let lights = Lights::new(&scene);
        let from = floor_point(&scene.materials[1]);
        let mut random = Random(2);
        const SAMPLES: u32 = 200_000;
        let mean = (0..SAMPLES)
            .filter_map(|_| lights.sample_light(&from, UP, (random.next() * 4_294_967_296.0) as u32, random.point()))
            .filter(|sample| !scene.occluded(&sample.shadow_ray))
            .map(|s| f64::from(s.radiance.x * s.direction.y * FRAC_1_PI / s.pdf))
            .sum::<f64>()
            / f64::from(SAMPLES);
        let h = f64::from(size) / 2.0;
        let corners = [(0.1, 0.2), (0.1, -0.2), (-0.1, 0.2), (-0.1, -0.2)];
        let exact: f64 = corners.iter().map(|(x, z)| 2.0 * corner_form_factor(h + x, h + z, f64::from(height))).sum();
        assert!((mean / exact - 1.0).abs() < 5e-3, "{mean} {exact}");
    }
}

#[test]
fn a_lamp_shines_to_one_side_only() {
    let scene = scene(3.0, 1.0, None);
    let lights = Lights::new(&scene);
    let mut above = floor_point(&scene.materials[1]);
    above.position.y = 2.0;
    assert!((0..50).all(|i| lights.sample_light(&above, UP, i << 26, Vec2::splat(0.3)).is_none()));
    let down = scene.intersect(&above.spawn(-Vec3::Y)).unwrap();
    assert_eq!(lights.light_pdf(UP, down.emitter.unwrap(), &down), 0.0);
    assert_eq!(lights.emitted(down.emitter.unwrap(), &down), Vec3::ZERO);
    let up = scene.intersect(&floor_point(&scene.materials[1]).spawn(Vec3::Y)).unwrap();
    assert_eq!(lights.emitted(up.emitter.unwrap(), &up), Vec3::splat(2.0));
}

#[test]
fn without_lights_nothing_is_sampled() {
    let scene = scene(3.0, 1.0, Some(Vec3::ZERO));
    let mut dark = scene;
    dark.emitters.clear();
    let lights = Lights::new(&dark);
    assert!(lights.sample_light(&floor_point(&dark.materials[1]), UP, 5, Vec2::ZERO).is_none());
}
