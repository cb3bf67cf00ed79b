//! Rays a second on one thread: the closest hit, and whether there is one at all, for the same random rays from inside
//! the scene. `Melem/s` are millions of rays a second. `TAMIS_BENCH_SCENE` may name a scene to measure in place of all others
//! (`scripts/compare_speed.py` does).

mod support;

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use support::random::Random;
use tracer::Ray;
use tracer::material::{Colour, Material, Surface};
use tracer::scene::{Instance, Mesh, Placement, Scene, load};

/// Rays per measurement: enough that no cache remembers their paths.
const RAYS: usize = 10_000;
const SOUP_TRIANGLES: u32 = 100_000;

/// Scenes that are measured where they are at hand.
const OPTIONAL: [(&str, &str); 2] = [
    ("conference", "../shared/scenes/conference/conference.obj"),
    ("sponza", "../shared/scenes/sponza-dabrovic/sponza.obj"),
];

/// Names the scene that is measured in place of all others.
const SCENE: &str = "TAMIS_BENCH_SCENE";

/// Small triangles in every direction all over a cube: nothing a hierarchy could exploit.
fn soup() -> Scene {
    let mut random = Random(1);
    let mut mesh = Mesh::default();
    for triangle in 0..SOUP_TRIANGLES {
        let centre = random.point();
        mesh.positions.extend((0..3).map(|_| centre + 0.02 * random.point()));
        mesh.triangles.push([0, 1, 2].map(|corner| 3 * triangle + corner));
        mesh.materials.push(0);
    }
    let whole = Instance { mesh: 0, placement: Placement::IDENTITY, motion: None };
    let surface = Surface::Diffuse { reflectance: Colour::constant(Vec3::splat(0.5)) };
    let grey = Material::new("grey", surface, Vec3::ZERO);
    Scene::new(vec![mesh], vec![whole], vec![grey], None).expect("a cube full of triangles")
}

fn rays_in(scene: &Scene) -> Vec<Ray> {
    let mut random = Random(2);
    (0..RAYS).map(|_| random.ray(scene.bounds())).collect()
}

fn measure(criterion: &mut Criterion, name: &str, scene: &Scene) {
    let rays = rays_in(scene);
    let mut group = support::brief_group(criterion, &format!("rays/{name}"));
    group.throughput(Throughput::Elements(RAYS as u64));
    group.bench_function("closest hit", |bencher| {
        bencher.iter(|| rays.iter().filter(|ray| black_box(scene.intersect(ray)).is_some()).count());
    });
    group.bench_function("occlusion", |bencher| {
        bencher.iter(|| rays.iter().filter(|ray| black_box(scene.occluded(ray))).count());
    });
    group.finish();
}

fn rays(criterion: &mut Criterion) {
    if let Ok(path) = std::env::var(SCENE) {
        let loaded = load(Path::new(&path)).unwrap_or_else(|error| panic!("{SCENE}: {error}"));
        eprintln!("{} triangles, tree built in {} s", loaded.triangles, loaded.build_seconds);
        measure(criterion, "given", &loaded.scene);
        return;
    }
    let study = load(&support::file("scenes/study.obj")).expect("the study scene is part of the repository");
    measure(criterion, "study", &study.scene);
    measure(criterion, "soup", &soup());
    for (name, path) in OPTIONAL {
        if let Ok(loaded) = load(&support::file(path)) {
            measure(criterion, name, &loaded.scene);
        }
    }
}

criterion_group!(benches, rays);
criterion_main!(benches);
