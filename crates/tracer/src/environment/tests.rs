use glam::{Vec2, Vec3};

use super::{Environment, EnvironmentMap};
use crate::bsdf::chi_square::{Random, integral, p_value};

/// A map with a bright texel, black ones, a gradient, and a width that no block divides.
fn map(width: usize, height: usize) -> EnvironmentMap {
    let mut random = Random(5);
    let mut texels: Vec<[f32; 3]> = (0..width * height).map(|_| [random.next(), random.next().powi(4), 0.1]).collect();
    texels[width + 2] = [40.0, 30.0, 20.0];
    texels[3 * width..4 * width].fill([0.0; 3]);
    EnvironmentMap::new(width, height, texels)
}

fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5
}

#[test]
fn the_density_integrates_to_one_and_is_that_of_the_samples() {
    for (size, turn) in [([16, 8], 0.0), ([7, 5], 77.0), ([2, 1], -130.0), ([1, 1], 0.0)] {
        let map = if size[1] > 4 {
            map(size[0], size[1])
        } else {
            EnvironmentMap::new(size[0], size[1], vec![[1.0; 3]; size[0] * size[1]])
        };
        let sky = Environment::mapped(map).turned_to(turn);
        // The test's bins are round z; the map's rows are round y.
        let total = integral(|d| sky.direction_pdf(d));
        assert!((total - 1.0).abs() < 5e-3, "{size:?}: {total}");
        let p = p_value(|d| sky.direction_pdf(d), |r| sky.sample_direction(r.point()).map(|s| s.direction));
        assert!(p > 1e-4, "{size:?}: p = {p}");
    }
}

#[test]
fn maps_with_blocks_of_texels_keep_every_bright_one() {
    let (width, height) = (5000, 3);
    let mut texels = vec![[0.0; 3]; width * height];
    texels[4999] = [1000.0; 3];
    texels[2 * width + 17] = [500.0; 3];
    let sky = Environment::mapped(EnvironmentMap::new(width, height, texels));
    let mut random = Random(3);
    let samples = 200_000;
    let mut mean = 0.0_f64;
    for _ in 0..samples {
        let sample = sky.sample_direction(random.point()).unwrap();
        mean += f64::from(sky.radiance(sample.direction).x / sample.pdf) / f64::from(samples);
    }
    let exact = integral_of(&sky);
    assert!((mean / exact - 1.0).abs() < 0.02, "{mean} {exact}");
}

/// ∫ L dω by the midpoint rule in u and v, fine enough for one texel of 5,000.
fn integral_of(sky: &Environment) -> f64 {
    const COLUMNS: usize = 20_000;
    const ROWS: usize = 60;
    let mut sum = 0.0;
    for row in 0..ROWS {
        let (sin, cos) = (std::f64::consts::PI * (row as f64 + 0.5) / ROWS as f64).sin_cos();
        for column in 0..COLUMNS {
            let (s, c) = (std::f64::consts::TAU * (column as f64 + 0.5) / COLUMNS as f64).sin_cos();
            let direction = Vec3::new((sin * s) as f32, cos as f32, (-sin * c) as f32);
            sum += f64::from(sky.radiance(direction).x) * sin;
        }
    }
    sum * std::f64::consts::PI / ROWS as f64 * std::f64::consts::TAU / COLUMNS as f64
}

#[test]
fn the_zenith_is_on_top_and_the_middle_of_the_map_is_plus_z() {
    // A column of its own for each quarter of the horizon; the first row is brighter.
    let quarters = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]];
    let (width, height) = (8, 4);
    let texels = (0..width * height).map(|i| quarters[i % width / 2].map(|c| if i < width { 5.0 * c } else { c }));
    let sky = Environment::mapped(EnvironmentMap::new(width, height, texels.collect()));
    let at = |x: f32, z: f32| sky.radiance(Vec3::new(x, 0.0, z).normalize());
    // u = ⅛, ⅜, ⅝, ⅞: halfway between the axes.
    assert!(close(at(1.0, -1.0), Vec3::X) && close(at(1.0, 1.0), Vec3::Y));
    assert!(close(at(-1.0, 1.0), Vec3::Z) && close(at(-1.0, -1.0), Vec3::new(1.0, 1.0, 0.0)));
    let up = sky.radiance(Vec3::new(0.1, 1.0, -0.1).normalize());
    assert!(close(up, 5.0 * Vec3::X), "{up}");
    // +z lies between the second quarter and the third.
    assert!(close(sky.radiance(Vec3::Z), Vec3::new(0.0, 0.5, 0.5)));
}

#[test]
fn a_turn_goes_counter_clockwise_seen_from_above() {
    let sky = Environment::mapped(map(16, 8));
    let turned = sky.clone().turned_to(90.0);
    let mut random = Random(9);
    for _ in 0..100 {
        let direction = crate::sampler::warp::sample_sphere(random.point());
        // A quarter turn round +y takes z to x and x to −z.
        let there = Vec3::new(direction.z, direction.y, -direction.x);
        assert!(
            (sky.radiance(direction) - turned.radiance(there)).length()
                < 1e-4 * (1.0 + sky.radiance(direction).length())
        );
    }
}

#[test]
fn the_mean_is_that_over_the_sphere() {
    let sky = Environment::mapped(EnvironmentMap::new(1, 2, vec![[3.0; 3], [1.0; 3]])).scaled(0.5);
    assert!(close(sky.mean(), Vec3::ONE));
    let constant = Environment::constant(Vec3::new(1.0, 2.0, 3.0)).scaled(2.0);
    assert_eq!((constant.mean(), constant.radiance(Vec3::Y)), (Vec3::new(2.0, 4.0, 6.0), Vec3::new(2.0, 4.0, 6.0)));
    assert_eq!(constant.direction_pdf(Vec3::Y), 0.0);
}

#[test]
fn a_black_map_is_never_sampled() {
    let sky = Environment::mapped(EnvironmentMap::new(4, 2, vec![[0.0; 3]; 8]));
    assert!(sky.sample_direction(Vec2::splat(0.3)).is_none());
    assert_eq!((sky.direction_pdf(Vec3::X), sky.radiance(Vec3::X)), (0.0, Vec3::ZERO));
}
