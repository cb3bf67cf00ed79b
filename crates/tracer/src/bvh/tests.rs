use glam::{DAffine3, DQuat, DVec3, Vec3};

use super::random::Random;
use super::{Bounds, Placement, ShearedRay, TriangleBvh, TriangleHit, WideBvh};
use crate::Ray;

type Triangle = [Vec3; 3];

fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, direction, t_max: f32::INFINITY, time: 0.0 }
}

fn build(triangles: &[Triangle]) -> TriangleBvh {
    TriangleBvh::build(triangles.len() as u32, |t| triangles[t as usize]).unwrap()
}

fn closest(bvh: &TriangleBvh, ray: &Ray) -> Option<TriangleHit> {
    bvh.closest(ray, &ShearedRay::new(ray), None, ray.t_max, |_| true)
}

fn occluded(bvh: &TriangleBvh, ray: &Ray) -> bool {
    bvh.occluded(ray, &ShearedRay::new(ray), None, ray.t_max, |_| true)
}

/// Möller and Trumbore's test in f64: distance, and the least barycentric weight (negative outside).
fn reference(ray: &Ray, [a, b, c]: Triangle) -> Option<(f64, f64)> {
    let [a, b, c] = [a, b, c].map(|v| v.as_dvec3());
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let p = d.cross(c - a);
    let determinant = p.dot(b - a);
    let q = (o - a).cross(b - a);
    let (u, v) = (p.dot(o - a) / determinant, q.dot(d) / determinant);
    let t = q.dot(c - a) / determinant;
    determinant.is_normal().then_some((t, u.min(v).min(1.0 - u - v)))
}

/// Compares every ray with the reference over all triangles; hits nearer to an edge than rounding can tell are either.
fn agrees(triangles: &[Triangle], rays: impl Iterator<Item = Ray>) {
    let bvh = build(triangles);
    let (mut hits, mut doubtful) = (0, 0);
    for ray in rays {
        let found = closest(&bvh, &ray);
        assert_eq!(found.is_some(), occluded(&bvh, &ray));
        let crossed: Vec<_> = triangles.iter().filter_map(|&t| reference(&ray, t)).filter(|c| c.0 > 0.0).collect();
        let least = |margin: f64| crossed.iter().filter(|c| c.1 > margin).map(|c| c.0).fold(f64::INFINITY, f64::min);
        let (surely, perhaps) = (least(1e-4), least(-1e-4));
        let distance = found.map_or(f64::INFINITY, |hit| f64::from(hit.distance));
        let slack = 1e-4 * distance.min(surely);
        assert!(distance <= surely + slack || surely == f64::INFINITY, "{ray:?}: {distance} beyond {surely}");
        assert!(distance >= perhaps - slack || distance == f64::INFINITY, "{ray:?}: {distance} before {perhaps}");
        hits += usize::from(found.is_some());
        doubtful += usize::from(surely != perhaps);
    }
    assert!(hits > 0 && doubtful * 20 < hits.max(20) * 20, "{hits} hits, {doubtful} of them in doubt");
}

fn soup(count: usize, size: f32, scale: f32, random: &mut Random) -> Vec<Triangle> {
    (0..count)
        .map(|_| {
            let centre = random.point();
            std::array::from_fn(|_| scale * (centre + size * random.point()))
        })
        .collect()
}

#[test]
fn random_triangles_of_any_scale_are_hit_as_by_brute_force() {
    let mut random = Random(1);
    for scale in [1.0, 1e-25, 1e25, 3e-8, 4e6] {
        for (count, size) in [(1, 0.5), (7, 0.3), (600, 0.1)] {
            let triangles = soup(count, size, scale, &mut random);
            let rays = (0..4000).map(|_| ray(scale * 2.0 * random.point(), random.direction()));
            agrees(&triangles, rays.collect::<Vec<_>>().into_iter());
        }
    }
}

#[test]
fn a_tree_built_in_chunks_finds_the_same() {
    let mut random = Random(7);
    for (count, size) in [(1, 1), (2, 1), (90, 3), (700, 64), (700, 700)] {
        let triangles = soup(count, 0.3, 1.0, &mut random);
        let whole = build(&triangles);
        let chunked = TriangleBvh::build_in_chunks(count as u32, |t| triangles[t as usize], size).unwrap();
        assert_eq!(whole.bounds(), chunked.bounds());
        for _ in 0..2000 {
            let ray = ray(1.5 * random.point(), random.direction());
            assert_eq!(closest(&whole, &ray), closest(&chunked, &ray));
            assert_eq!(occluded(&whole, &ray), occluded(&chunked, &ray));
        }
    }
    assert!(TriangleBvh::build_in_chunks(0, |_| unreachable!(), 4).is_none());
}

#[test]
fn coplanar_and_repeated_triangles_give_the_lowest_number_at_the_least_distance() {
    let mut random = Random(2);
    let flat = |v: Vec3| Vec3::new(v.x, v.y, 0.5);
    let mut triangles: Vec<Triangle> = soup(40, 0.6, 1.0, &mut random).iter().map(|t| t.map(flat)).collect();
    triangles.extend(triangles.clone());
    triangles.extend(triangles.clone());
    let bvh = build(&triangles);
    for _ in 0..5000 {
        let ray = ray(random.point() - 2.0 * Vec3::Z, random.direction());
        let Some(hit) = closest(&bvh, &ray) else { continue };
        assert!(hit.triangle < 40, "a copy was preferred");
    }
    agrees(&triangles, (0..5000).map(|_| ray(random.point() - 2.0 * Vec3::Z, random.direction())));
}

/// The surface of the cube [-1, 1]³, each side in n × n squares of two triangles.
fn cube(n: usize) -> Vec<Triangle> {
    let mut triangles = vec![];
    for axis in 0..3 {
        for side in [-1.0f32, 1.0] {
            let point = |i: usize, j: usize| {
                let mut p = Vec3::ZERO;
                p[axis] = side;
                p[(axis + 1) % 3] = -1.0 + 2.0 * i as f32 / n as f32;
                p[(axis + 2) % 3] = -1.0 + 2.0 * j as f32 / n as f32;
                p
            };
            for (i, j) in (0..n * n).map(|k| (k % n, k / n)) {
                triangles.push([point(i, j), point(i + 1, j), point(i + 1, j + 1)]);
                triangles.push([point(i, j), point(i + 1, j + 1), point(i, j + 1)]);
            }
        }
    }
    triangles
}

#[test]
fn axis_parallel_rays_hit_the_faces_vertices_and_edges_they_run_through() {
    let bvh = build(&cube(8));
    // Multiples of 1/8 run through vertices, edges and along the boxes of the tree; ±1 in the cube's own faces.
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            for (i, j) in (0..33 * 33).map(|k| (k % 33, k / 33)) {
                let mut origin = Vec3::splat(-3.0 * sign);
                origin[(axis + 1) % 3] = -1.0 + i as f32 / 16.0;
                origin[(axis + 2) % 3] = -1.0 + j as f32 / 16.0;
                let mut direction = Vec3::splat(if (i + j) % 2 == 0 { 0.0 } else { -0.0 });
                direction[axis] = sign;
                let hit = closest(&bvh, &ray(origin, direction)).expect("the ray runs into the cube");
                assert_eq!(hit.distance, 2.0);
            }
        }
    }
}

#[test]
fn axis_parallel_rays_beside_a_box_miss_it() {
    let bvh = build(&cube(3));
    for outside in [1.001, -1.5, 30.0] {
        assert_eq!(closest(&bvh, &ray(Vec3::new(outside, 0.1, -9.0), Vec3::Z)), None);
        assert_eq!(closest(&bvh, &ray(Vec3::new(0.2, 0.1, 9.0), Vec3::Z)), None);
    }
}

#[test]
fn no_ray_leaves_a_closed_box_through_vertices_edges_or_anywhere() {
    let mut random = Random(3);
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.7);
    for (scale, shift) in [(1.0, 0.0), (1e-12, 0.0), (3e3, 1e5), (1e20, 0.0), (1.0, 900.0)] {
        let place = |p: Vec3| (turn * (p.as_dvec3() * scale) + DVec3::new(1.0, -0.4, 0.6) * shift).as_vec3();
        let triangles: Vec<Triangle> = cube(6).into_iter().map(|t| t.map(place)).collect();
        let bvh = build(&triangles);
        for _ in 0..20_000 {
            let origin = place(0.9 * random.point());
            let [a, b, c] = triangles[random.index(triangles.len())];
            let weight = if random.index(2) == 0 { 0.0 } else { random.unit() };
            let target = if random.index(4) == 0 { place(10.0 * random.direction()) } else { a.lerp(b, weight) };
            let target = if random.index(4) == 0 { target.lerp(c, random.unit()) } else { target };
            let direction = (target.as_dvec3() - origin.as_dvec3()).normalize().as_vec3();
            assert!(closest(&bvh, &ray(origin, direction)).is_some(), "leak from {origin} to {target}");
        }
    }
}

#[test]
fn a_placed_mesh_is_hit_like_the_same_triangles_moved() {
    let mut random = Random(4);
    let triangles = soup(300, 0.2, 1.0, &mut random);
    let bvh = build(&triangles);
    for _ in 0..20 {
        let turn = DQuat::from_axis_angle(random.direction().as_dvec3(), 3.0 * f64::from(random.unit()));
        let scale = DVec3::new(2.0, 0.01, -30.0) * f64::from(random.unit() + 0.1);
        let map = DAffine3::from_scale_rotation_translation(scale, turn, 50.0 * random.point().as_dvec3());
        let placement = Placement::new(map).unwrap();
        let moved: Vec<Triangle> = triangles.iter().map(|t| t.map(|v| placement.point(v))).collect();
        let world = build(&moved);
        for _ in 0..2000 {
            let target = moved[random.index(moved.len())][0];
            let origin = target + 40.0 * random.point();
            let ray = ray(origin, (target + 0.3 * random.point() - origin).normalize());
            let sheared = ShearedRay::new(&ray);
            let placed = bvh.closest(&ray, &sheared, Some(&placement), f32::INFINITY, |_| true);
            assert_eq!(placed, closest(&world, &ray));
            assert_eq!(bvh.occluded(&ray, &sheared, Some(&placement), f32::INFINITY, |_| true), placed.is_some());
        }
    }
}

#[test]
fn hits_count_from_just_beyond_the_origin_to_just_before_t_max() {
    let bvh = build(&[[Vec3::new(-1.0, -1.0, 0.0), Vec3::new(2.0, -1.0, 0.0), Vec3::new(-1.0, 2.0, 0.0)]]);
    for height in [1e-30f32, 1e-9, 1.0, 1e9] {
        let down = ray(Vec3::new(0.1, 0.1, height), -Vec3::Z);
        let distance = closest(&bvh, &down).unwrap().distance;
        assert!((distance - height).abs() <= 2.0 * f32::EPSILON * height);
        let before = Ray { t_max: distance, ..down };
        let after = Ray { t_max: distance.next_up(), ..down };
        assert!(closest(&bvh, &after).is_some() && occluded(&bvh, &after));
        assert!(closest(&bvh, &before).is_none() && !occluded(&bvh, &before));
        assert_eq!(closest(&bvh, &ray(down.origin, Vec3::Z)), None);
    }
    assert_eq!(closest(&bvh, &ray(Vec3::new(0.1, 0.1, 0.0), Vec3::Z)), None);
}

#[test]
fn needles_and_zero_area_triangles_do_no_harm() {
    let mut random = Random(5);
    let mut triangles = soup(200, 0.2, 1.0, &mut random);
    agrees(&triangles, (0..2000).map(|_| ray(2.0 * random.point(), random.direction())));
    let sound = build(&triangles);
    for i in 0..200 {
        let [a, b, _] = triangles[i];
        triangles.extend([[a, a, a], [a, b, a], [a, b, a.midpoint(b)]]);
    }
    let more = build(&triangles);
    for _ in 0..10_000 {
        let ray = ray(2.0 * random.point(), random.direction());
        assert_eq!(closest(&sound, &ray).map(|h| h.distance), closest(&more, &ray).map(|h| h.distance));
    }
}

#[test]
fn a_tree_of_one_line_of_ever_larger_triangles_is_walked_whatever_its_depth() {
    let triangle = |i: i32| {
        let x = 1.7f32.powi(i);
        [Vec3::new(x, -x, -x), Vec3::new(x, 2.0 * x, -x), Vec3::new(x, -x, 2.0 * x)]
    };
    let triangles: Vec<Triangle> = (-150..150).map(triangle).collect();
    let bvh = build(&triangles);
    for (i, t) in triangles.iter().enumerate() {
        let origin = Vec3::new(t[0].x.next_down(), 0.0, 0.0);
        assert_eq!(closest(&bvh, &ray(origin, Vec3::X)).map(|hit| hit.triangle), Some(i as u32));
    }
}

#[test]
fn a_ray_that_is_not_finite_hits_nothing() {
    let bvh = build(&cube(3));
    for bad in [f32::NAN, f32::INFINITY] {
        for ray in [ray(Vec3::new(bad, 0.0, 0.0), Vec3::X), ray(Vec3::ZERO, Vec3::new(0.0, bad, 0.0))] {
            assert!(closest(&bvh, &ray).is_none() && !occluded(&bvh, &ray));
        }
    }
}

#[test]
fn the_tree_is_the_same_whatever_the_number_of_threads() {
    let boxes: Vec<Bounds> = soup(30_000, 0.02, 1.0, &mut Random(6)).into_iter().map(Bounds::of).collect();
    let with_threads = |count| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
        format!("{:?}", pool.install(|| WideBvh::build(&boxes, 4)))
    };
    let alone = with_threads(1);
    assert!(alone == with_threads(3) && alone == with_threads(2));
}
