use super::super::tests::floor_point;
use super::*;
use crate::bsdf::chi_square::Random;
use crate::material::{Colour, Material, Surface};

const ANY: Receiver = Receiver { position: Vec3::ZERO, normal: Vec3::Y, two_sided: true };

fn floor_at(position: Vec3, material: &Material) -> Interaction<'_> {
    Interaction { position, ..floor_point(material) }
}

fn dull() -> Material {
    Material::new("m", Surface::Diffuse { reflectance: Colour::constant(Vec3::ZERO) }, Vec3::ZERO)
}

/// Irradiance of a floor at `position`, by samples.
fn irradiance(lights: &[DeltaLight], position: Vec3) -> f64 {
    let (material, mut random) = (dull(), Random(3));
    let from = floor_at(position, &material);
    let all = DeltaLights::new(lights, 1.0, 0.0);
    const SAMPLES: u32 = 4096;
    let up = Receiver { two_sided: false, ..ANY };
    let samples =
        (0..SAMPLES).filter_map(|i| all.sample(&from, up, (f64::from(i) + 0.5) / f64::from(SAMPLES), random.point()));
    samples.map(|s| f64::from(s.radiance.x * s.direction.y.max(0.0) / s.pdf)).sum::<f64>() / f64::from(SAMPLES)
}

#[test]
fn a_point_lights_a_floor_by_the_inverse_square_and_the_cosine() {
    let point = DeltaLight::Point { position: Vec3::new(1.0, 2.0, -1.0), intensity: Vec3::splat(5.0) };
    for at in [Vec3::ZERO, Vec3::new(1.0, 0.0, -1.0), Vec3::new(7.0, 1.0, 0.0)] {
        let span = (Vec3::new(1.0, 2.0, -1.0) - at).as_dvec3();
        let expected = 5.0 * span.y / span.length().powi(3);
        assert!((irradiance(&[point], at) / expected - 1.0).abs() < 1e-5, "{at}");
    }
}

#[test]
fn a_sun_lights_a_floor_by_its_irradiance_whatever_its_size() {
    for angle in [0.0_f32, 0.53, 10.0, 60.0] {
        let direction = Vec3::new(1.0, -2.0, 0.5).normalize();
        let sun = DeltaLight::Sun { direction, irradiance: Vec3::splat(3.0), angle: angle.to_radians() };
        let found = irradiance(&[sun], Vec3::ZERO);
        let expected = 3.0 * f64::from(-direction.y);
        assert!(
            (found / expected - 1.0).abs() < 0.01 * f64::from(angle.to_radians()) + 1e-5,
            "{angle}: {found} {expected}"
        );
    }
}

#[test]
fn a_sun_s_samples_fill_its_disc_evenly() {
    let (half, mut random) = (0.3_f32, Random(5));
    let towards = Vec3::new(0.0, 0.6, 0.8);
    let mut inner = 0;
    for _ in 0..20_000 {
        let (direction, _) = on_disc(towards, half, random.point());
        let cosine = direction.dot(towards);
        assert!(cosine >= half.cos() - 1e-6);
        // Half of the solid angle lies within this cone.
        inner += u32::from(1.0 - cosine < 0.5 * (1.0 - half.cos()));
    }
    assert!((f64::from(inner) / 20_000.0 - 0.5).abs() < 0.015, "{inner}");
}

#[test]
fn a_spot_falls_off_smoothly_to_its_rim() {
    let spot = DeltaLight::spot(Vec3::new(0.0, 4.0, 0.0), -Vec3::Y, Vec3::splat(2.0), [40.0, 15.0]);
    let share = |degrees: f32| {
        let x = 4.0 * degrees.to_radians().tan();
        let span = glam::DVec2::new(f64::from(x), 4.0);
        irradiance(&[spot], Vec3::new(x, 0.0, 0.0)) * span.length().powi(3) / (2.0 * 4.0)
    };
    assert!((share(0.0) - 1.0).abs() < 1e-5 && (share(24.9) - 1.0).abs() < 1e-3);
    assert!(share(40.1) == 0.0 && share(39.9) < 1e-3);
    let (low, high) = (40.0_f64.to_radians().cos(), 25.0_f64.to_radians().cos());
    let t = (32.0_f64.to_radians().cos() - low) / (high - low);
    assert!((share(32.0) - t * t * (3.0 - 2.0 * t)).abs() < 1e-4);
}

/// A narrow spot lights a disc of radius d θ; with a hard rim all of it alike: E = Φ ÷ (π d² θ²).
#[test]
fn narrow_spots_have_the_power_they_are_said_to_have() {
    for degrees in [0.001_f32, 0.02, 1.0] {
        let spot = DeltaLight::spot(Vec3::Y * 4.0, -Vec3::Y, Vec3::ONE, [degrees, 0.0]).of_power(Vec3::splat(7.0));
        let theta = f64::from(degrees).to_radians();
        let expected = 7.0 / (std::f64::consts::PI * (4.0 * theta).powi(2));
        let inside = irradiance(&[spot], Vec3::X * (0.9 * 4.0 * theta) as f32);
        assert!((inside / expected - 1.0).abs() < 1e-3, "{degrees}: {inside}, expected {expected}");
        assert_eq!(irradiance(&[spot], Vec3::X * (1.1 * 4.0 * theta) as f32), 0.0, "{degrees}");
    }
}

#[test]
fn power_is_what_a_sphere_round_the_light_gets() {
    let material = dull();
    for light in [
        DeltaLight::Point { position: Vec3::ZERO, intensity: Vec3::ZERO }.of_power(Vec3::splat(7.0)),
        DeltaLight::spot(Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8), Vec3::ONE, [50.0, 20.0]).of_power(Vec3::splat(7.0)),
    ] {
        let all = DeltaLights::new(std::slice::from_ref(&light), 1.0, 0.0);
        let intensity = |direction: Vec3| {
            let seen = all.sample(&floor_at(2.0 * direction, &material), ANY, 0.5, Vec2::ZERO);
            seen.map_or(0.0, |sample| 4.0 * sample.radiance.x / sample.pdf)
        };
        let power = crate::bsdf::chi_square::integral(intensity);
        assert!((power / 7.0 - 1.0).abs() < 2e-3, "{light:?}: {power}");
    }
}

#[test]
fn of_many_lights_each_counts_and_those_behind_do_not() {
    let point =
        |x: f32, y: f32, i: f32| DeltaLight::Point { position: Vec3::new(x, y, 0.0), intensity: Vec3::splat(i) };
    let lights = [point(0.0, 2.0, 1.0), point(3.0, 1.0, 40.0), point(0.0, -1.0, 1e6), point(-1.0, 5.0, 0.0)];
    let expected: f64 = lights.iter().map(|light| irradiance(&[*light], Vec3::ZERO)).sum();
    assert!((irradiance(&lights, Vec3::ZERO) / expected - 1.0).abs() < 1e-3);
    let (material, behind) = (dull(), [lights[2]]);
    let up = Receiver { two_sided: false, ..ANY };
    assert!(
        DeltaLights::new(&behind, 1.0, 0.0).sample(&floor_at(Vec3::ZERO, &material), up, 0.5, Vec2::ZERO).is_none()
    );
}

#[test]
fn choices_are_shared_with_other_lights() {
    let lights = [DeltaLight::Point { position: Vec3::Y, intensity: Vec3::ONE }];
    for (others, rest) in [(0.0, 0.0), (1e-6, 0.25), (f64::from(4.0 * PI), 0.5), (1e9, 0.75)] {
        let all = DeltaLights::new(&lights, 1.0, others);
        assert!((all.fork().rest() - rest).abs() < 1e-6);
        let (mut own, mut least, mut most) = (0, u32::MAX, 0);
        for i in 0..1 << 12 {
            match all.fork().take(i << 20 | 1 << 19) {
                Ok(choice) => own += u32::from((0.0..1.0).contains(&choice)),
                Err(other) => (least, most) = (least.min(other), most.max(other)),
            }
        }
        assert!((f64::from(own) / 4096.0 + f64::from(rest) - 1.0).abs() < 1e-3);
        assert!(rest == 0.0 || (least < 1 << 22 && most > u32::MAX - (1 << 22)), "the rest is uniform again");
    }
    assert_eq!(DeltaLights::new(&[], 1.0, 1.0).fork().rest(), 1.0);
}
