use glam::{DAffine3, DVec3, Vec2, Vec3};

use super::{Dropped, Instance, Mesh, Placement, Scene, SceneError};
use crate::Ray;
use crate::bvh::random::Random;
use crate::interaction::Interaction;
use crate::material::{Colour, Material, Surface};

fn grey(emission: Vec3) -> Material {
    let surface = Surface::Diffuse { reflectance: Colour::constant(Vec3::splat(0.5)) };
    Material::new("grey", surface, emission)
}

/// The square [0, 1]² at z = 0, facing +z; its first triangle is of material 0, the second of material 1.
fn square() -> Mesh {
    Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        materials: vec![0, 1],
        ..Mesh::default()
    }
}

fn standing(mesh: usize, scale: DVec3, translation: DVec3) -> Instance {
    let map = DAffine3::from_scale_rotation_translation(scale, glam::DQuat::IDENTITY, translation);
    Instance { mesh, placement: Placement::new(map).unwrap(), motion: None }
}

fn materials() -> Vec<Material> {
    vec![grey(Vec3::ZERO), grey(Vec3::new(1.0, 2.0, 3.0))]
}

fn down(x: f32, y: f32) -> Ray {
    Ray { origin: Vec3::new(x, y, 9.0), direction: -Vec3::Z, t_max: f32::INFINITY, time: 0.25 }
}

#[test]
fn a_hit_knows_the_surface() {
    let scene = Scene::new(vec![square()], vec![standing(0, DVec3::ONE, DVec3::ZERO)], materials(), None).unwrap();
    let hit = scene.intersect(&down(0.25, 0.75)).unwrap();
    assert!((hit.position - Vec3::new(0.25, 0.75, 0.0)).length() < 1e-6);
    assert_eq!((hit.geometric_normal, hit.shading_normal), (Vec3::Z, Vec3::Z));
    assert!((hit.uv.0[0] - Vec2::new(0.25, 0.75)).length() < 1e-6);
    assert_eq!((hit.outgoing, hit.time, hit.emitter), (Vec3::Z, 0.25, Some(0)));
    assert!((hit.distance - 9.0).abs() < 1e-5);
    assert_eq!(scene.intersect(&down(0.75, 0.25)).unwrap().emitter, None);
    assert!(scene.intersect(&down(1.5, 0.25)).is_none());
    assert_eq!(scene.bounds().max, Vec3::new(1.0, 1.0, 0.0));
}

#[test]
fn instances_and_merged_copies_of_a_mesh_look_the_same() {
    let stands = [
        standing(0, DVec3::new(2.0, 1.0, 1.0), DVec3::new(-3.0, 0.5, 1.0)),
        standing(0, DVec3::new(-1.0, 3.0, 2.0), DVec3::new(0.5, -2.0, -1.0)),
        standing(0, DVec3::ONE, DVec3::ZERO),
    ];
    let shared = Scene::new(vec![square()], stands.to_vec(), materials(), None).unwrap();
    let copies = (0..3).map(|i| Instance { mesh: i, ..stands[i] }).collect();
    let merged = Scene::new(vec![square(), square(), square()], copies, materials(), None).unwrap();
    assert_eq!(shared.bounds(), merged.bounds());
    assert_eq!((shared.triangles(), merged.triangles()), (6, 6));
    for (a, b) in shared.emitters.iter().zip(&merged.emitters) {
        assert_eq!((a.normal, a.area, a.radiance), (b.normal, b.area, b.radiance));
    }
    let mut random = Random(1);
    let mut hits = 0;
    for _ in 0..20_000 {
        let origin = 4.0 * random.point();
        let direction = random.direction();
        let ray = Ray { origin, direction, t_max: 20.0 * random.unit(), time: 0.0 };
        let (a, b) = (shared.intersect(&ray), merged.intersect(&ray));
        assert_eq!(a.is_some(), b.is_some());
        assert_eq!((shared.occluded(&ray), merged.occluded(&ray)), (a.is_some(), a.is_some()));
        let (Some(a), Some(b)) = (a, b) else { continue };
        hits += 1;
        assert_eq!((a.geometric_normal, a.emitter), (b.geometric_normal, b.emitter));
        assert!((a.distance - b.distance).abs() < 1e-6 * a.distance);
        assert!((a.position - b.position).length() < 1e-5 && (a.uv.0[0] - b.uv.0[0]).length() < 1e-5);
    }
    assert!(hits > 200);
}

#[test]
fn a_mirrored_mesh_keeps_its_outside_outside() {
    let mirrored = standing(0, DVec3::new(-1.0, 1.0, 1.0), DVec3::ZERO);
    for stands in [vec![mirrored], vec![mirrored, standing(0, DVec3::ONE, DVec3::X * 5.0)]] {
        let scene = Scene::new(vec![square()], stands, materials(), None).unwrap();
        assert_eq!(scene.intersect(&down(-0.5, 0.4)).unwrap().geometric_normal, Vec3::Z);
        assert_eq!(scene.emitters[0].normal, Vec3::Z);
    }
}

#[test]
fn emitters_have_their_place_area_and_radiance() {
    let stands = vec![standing(0, DVec3::splat(2.0), DVec3::Z), standing(0, DVec3::ONE, DVec3::ZERO)];
    let scene = Scene::new(vec![square()], stands, materials(), None).unwrap();
    assert_eq!(scene.emitters.len(), 2);
    let far = scene.emitters[scene.intersect(&down(0.5, 1.5)).unwrap().emitter.unwrap() as usize];
    assert_eq!((far.area, far.normal, far.radiance), (2.0, Vec3::Z, Vec3::new(1.0, 2.0, 3.0)));
    assert_eq!(far.vertices[1], Vec3::new(2.0, 2.0, 1.0));
}

#[test]
fn shading_normals_are_interpolated_and_flipped_to_the_side_of_the_winding() {
    let tilted = Vec3::new(0.6, 0.0, 0.8);
    for sign in [1.0, -3.0] {
        let mesh = Mesh { normals: vec![sign * tilted; 4], ..square() };
        let scene = Scene::new(vec![mesh], vec![standing(0, DVec3::ONE, DVec3::ZERO)], materials(), None).unwrap();
        assert!((scene.intersect(&down(0.2, 0.3)).unwrap().shading_normal - tilted).length() < 1e-6);
    }
    let stretched = standing(0, DVec3::new(4.0, 1.0, 1.0), DVec3::ZERO);
    let mesh = Mesh { normals: vec![tilted; 4], ..square() };
    let scene = Scene::new(vec![mesh], vec![stretched; 2], materials(), None).unwrap();
    let expected = Vec3::new(0.6 / 4.0, 0.0, 0.8).normalize();
    assert!((scene.intersect(&down(0.2, 0.3)).unwrap().shading_normal - expected).length() < 1e-6);
}

#[test]
fn useless_triangles_are_dropped_and_counted() {
    let mut mesh = square();
    mesh.positions.extend([Vec3::new(f32::NAN, 0.0, 0.0), Vec3::new(0.0, f32::INFINITY, 0.0)]);
    mesh.uvs.extend([Vec2::ZERO; 2]);
    mesh.triangles.extend([[0, 0, 1], [0, 1, 4], [0, 5, 1], [0, 2, 2]]);
    mesh.materials.extend([0; 4]);
    let scene = Scene::new(vec![mesh], vec![standing(0, DVec3::ONE, DVec3::ZERO)], materials(), None).unwrap();
    assert_eq!(scene.dropped(), Dropped { degenerate: 2, not_finite: 2 });
    assert_eq!(scene.triangles(), 2);
    let nothing = Mesh { triangles: vec![[0, 0, 1]], materials: vec![0], ..square() };
    let refused = Scene::new(vec![nothing], vec![standing(0, DVec3::ONE, DVec3::ZERO)], materials(), None);
    assert!(matches!(refused, Err(SceneError::Empty { dropped: Dropped { degenerate: 1, .. } })));
}

#[test]
fn indices_that_point_to_nothing_are_refused() {
    let stand = standing(0, DVec3::ONE, DVec3::ZERO);
    let build = |mesh: Mesh, stand| Scene::new(vec![mesh], vec![stand], materials(), None).unwrap_err().to_string();
    let bad_vertex = Mesh { triangles: vec![[0, 1, 4], [0, 1, 2]], ..square() };
    assert_eq!(build(bad_vertex, stand), "vertex 4 does not exist: there are 4");
    assert_eq!(build(Mesh { materials: vec![0, 2], ..square() }, stand), "material 2 does not exist: there are 2");
    assert_eq!(build(square(), Instance { mesh: 1, ..stand }), "mesh 1 does not exist: there are 1");
}

/// A sphere of about 2 n² triangles with radius 1.
fn sphere(n: usize) -> Mesh {
    let point = |i: usize, j: usize| {
        let (theta, phi) = (std::f32::consts::PI * i as f32 / n as f32, std::f32::consts::TAU * j as f32 / n as f32);
        Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    };
    let index = |i: usize, j: usize| (i * n + j % n) as u32;
    let quads = (0..n * n).map(|k| (k / n, k % n));
    let triangles: Vec<_> = quads
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let positions = (0..(n + 1) * n).map(|k| point(k / n, k % n)).collect();
    Mesh { positions, materials: vec![0; triangles.len()], triangles, ..Mesh::default() }
}

/// Spheres of several sizes far from the origin and near it, as one merged mesh or as instances.
fn spheres(instanced: bool) -> Scene {
    let place = |mesh: usize, i: usize| {
        let radius = [1.0, 1e-3, 50.0][i % 3];
        standing(if instanced { 0 } else { mesh }, DVec3::splat(radius), DVec3::new(300.0, -70.0, 1.0) * (i / 3) as f64)
    };
    let meshes = vec![sphere(16); if instanced { 1 } else { 6 }];
    Scene::new(meshes, (0..6).map(|i| place(i, i)).collect(), materials(), None).unwrap()
}

#[test]
fn spawned_rays_do_not_find_the_surface_they_leave() {
    let mut random = Random(7);
    for scene in [spheres(false), spheres(true)] {
        let (mut outside, mut inside) = (0, 0);
        for _ in 0..30_000 {
            let origin = Vec3::new(300.0, -70.0, 1.0) * (random.index(2) as f32) + 0.999 * random.point();
            let ray = Ray { origin, direction: random.direction(), t_max: f32::INFINITY, time: 0.5 };
            let Some(hit) = scene.intersect(&ray) else { continue };
            // A convex surface cannot be seen from a point on it when looking away from its inside.
            let outward = random.direction();
            let outward = outward * outward.dot(hit.geometric_normal).signum();
            let away = hit.spawn(outward);
            assert_eq!(away.time, 0.5);
            let same = |other: &Interaction| {
                (other.position - hit.position).length() < 1e-4 * hit.position.length()
                    && other.geometric_normal.dot(hit.geometric_normal) > 0.999
            };
            assert!(!scene.intersect(&away).is_some_and(|other| same(&other)));
            outside += 1;
            // And from inside a closed surface there is always an other side.
            let inward = hit.spawn(-outward);
            assert!(scene.intersect(&inward).is_some(), "a leak at {}", hit.position);
            inside += usize::from(scene.occluded(&inward));
        }
        assert!(outside > 10_000 && inside == outside);
    }
}

/// The cube [-1, 1]³.
fn cube() -> Mesh {
    let positions = crate::bvh::Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE }.corners().to_vec();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions, triangles, materials: vec![0; 12], ..Mesh::default() }
}

#[test]
fn two_points_of_a_convex_surface_see_each_other_through_its_inside() {
    let mut random = Random(8);
    // Far from zero, rounding would dent the sphere's faces; those of the cube stay flat.
    let cases = [(sphere(12), 1.0, 0.0), (sphere(12), 1e-6, 0.0), (cube(), 1.0, 1024.0), (cube(), 4096.0, 64.0)];
    for (mesh, scale, shift) in cases {
        let map = standing(0, DVec3::splat(scale), DVec3::new(1.0, 2.0, -0.5) * shift);
        let scene = Scene::new(vec![mesh], vec![map], materials(), None).unwrap();
        let centre = map.placement.point(Vec3::ZERO);
        for _ in 0..20_000 {
            let from = Ray { origin: centre, direction: random.direction(), t_max: f32::INFINITY, time: 0.0 };
            let to = Ray { direction: random.direction(), ..from };
            let (a, b) = (scene.intersect(&from).unwrap(), scene.intersect(&to).unwrap());
            // Points of one face see nothing of the inside.
            if a.geometric_normal.dot(b.geometric_normal) < 0.999 {
                let between = a.spawn_to(b.position, b.geometric_normal, b.position_error);
                // A target on an edge lies in two faces, and only one normal was given.
                let at_edge =
                    |h: Interaction| h.distance > 0.9999 * between.t_max && h.geometric_normal != b.geometric_normal;
                assert!(scene.intersect(&between).is_none_or(at_edge));
                assert_eq!(scene.occluded(&between), scene.intersect(&between).is_some());
            }
            // Something stands between a point and what lies beyond the surface on its inner side.
            let beyond = b.position + (b.position - centre);
            let behind = (beyond - a.position).normalize().dot(a.geometric_normal) < -1e-2;
            assert!(!behind || scene.occluded(&a.spawn_to(beyond, b.geometric_normal, Vec3::ZERO)));
        }
    }
}
