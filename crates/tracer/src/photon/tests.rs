use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::map::{Photon, PhotonMap};
use super::target::Targets;
use crate::interaction::Interaction;
use crate::material::{Colour, Material, Surface};
use crate::sampler::warp::sample_sphere;

/// Points of the unit square, and a third number for each.
fn points(count: u32) -> impl Iterator<Item = (Vec2, f32)> {
    let at = |i: u32, step: f64| (f64::from(i) * step % 1.0) as f32;
    (0..count).map(move |i| (Vec2::new(at(i, 0.819_172_5), at(i, 0.671_043_6)), at(i, 0.549_700_5)))
}

/// Two small triangles far from one another.
fn targets() -> Targets {
    let triangle = |corner: Vec3, size: f32| [corner, corner + size * Vec3::X, corner + size * Vec3::Y];
    Targets::new(vec![triangle(Vec3::new(3.0, 0.0, 0.0), 0.5), triangle(Vec3::new(-4.0, 1.0, 2.0), 1.0)]).unwrap()
}

#[test]
fn directions_to_targets_have_the_density_they_say() {
    let targets = targets();
    for point in [Vec3::ZERO, Vec3::new(3.1, 0.1, 0.2), Vec3::new(0.0, -9.0, 1.0)] {
        let directions = || points(20_000).map(|(u, choice)| targets.direction_from(point, choice, u));
        let mean_of_reciprocals =
            directions().map(|d| f64::from(1.0 / targets.direction_pdf(point, d))).sum::<f64>() / 20_000.0;
        // Rays that meet a ball, counted over the sphere.
        let solid_angle = 4.0
            * PI
            * points(200_000).filter(|(u, _)| targets.direction_pdf(point, sample_sphere(*u)) > 0.0).count() as f32
            / 200_000.0;
        assert!((mean_of_reciprocals as f32 / solid_angle - 1.0).abs() < 0.05, "{mean_of_reciprocals} {solid_angle}");
    }
}

#[test]
fn lines_through_targets_have_the_density_they_say() {
    let (targets, along) = (targets(), Vec3::new(0.6, 0.0, 0.8));
    let through = || points(5000).map(|(u, choice)| targets.point_across(along, choice, u));
    let densities: Vec<f32> = through().map(|point| targets.point_pdf(point, along)).collect();
    // Both balls are seen apart from here: the density is the same within each of them.
    assert!(densities.iter().all(|density| (density / densities[0] - 1.0).abs() < 1e-5 && *density > 0.0));
    let balls = [0.5_f32, 1.0].map(|size| PI * (size * size / 2.0));
    assert!((densities[0] * balls.iter().sum::<f32>() - 1.0).abs() < 1e-3, "{}", densities[0]);
    assert_eq!(targets.point_pdf(Vec3::new(0.0, 50.0, 0.0), along), 0.0);
}

#[test]
fn what_shines_nowhere_special_has_no_targets() {
    assert!(Targets::new(vec![]).is_none());
}

#[test]
fn the_map_finds_all_photons_near_a_point_on_its_surface() {
    let material = Material::new("m", Surface::Diffuse { reflectance: Colour::constant(Vec3::ONE) }, Vec3::ZERO);
    let photon = |(u, z): (Vec2, f32)| {
        let normal = if z < 0.5 { Vec3::Z } else { Vec3::X };
        let hit = Interaction { distance: 1.0, ..Interaction::facing(u.extend(0.05 * z), normal, &material) };
        Photon::new(&hit, Vec3::splat(z), 1.0, 1)
    };
    for count in [0, 1, 8, 9, 1000] {
        let map = PhotonMap::new(points(count).map(photon).collect(), count);
        for (centre, z) in points(50) {
            let (centre, reach) = (centre.extend(0.02), 0.2 * z);
            let mut found = vec![];
            map.near(centre, Vec3::Z, reach * reach, |photon| found.push(photon.radiance.x));
            let is_near = |(u, z): &(Vec2, f32)| *z < 0.5 && u.extend(0.05 * z).distance(centre) <= reach;
            let mut expected: Vec<f32> = points(count).filter(is_near).map(|(_, z)| z).collect();
            found.sort_by(f32::total_cmp);
            expected.sort_by(f32::total_cmp);
            assert_eq!(found, expected);
        }
    }
}
