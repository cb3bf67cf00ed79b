//! Small scenes whose pictures are known in closed form.

use glam::{Vec2, Vec3};
use stack::{ComponentRole, FeatureStack, Silent, Size, Window};

use super::{TraceReport, TraceSettings, trace};
use crate::camera::{Camera, CameraDescription};
use crate::environment::Environment;
use crate::film::Film;
use crate::material::{Colour, Material, Surface};
use crate::scene::{Instance, Mesh, Motion, Placement, Scene};

pub(super) fn grey(value: f32) -> Colour {
    Colour::constant(Vec3::splat(value))
}

pub(super) fn diffuse(reflectance: f32) -> Surface {
    Surface::Diffuse { reflectance: grey(reflectance) }
}

pub(super) fn lamp(radiance: f32) -> (Surface, f32) {
    (diffuse(0.0), radiance)
}

/// Pieces of a scene under construction, each with a material of its own.
#[derive(Default)]
pub(super) struct Pieces {
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    motions: Vec<(usize, Motion)>,
}

impl Pieces {
    fn add(mut self, positions: Vec<Vec3>, triangles: Vec<[u32; 3]>, (surface, emission): (Surface, f32)) -> Self {
        let material = self.materials.len() as u32;
        self.materials.push(Material::new(format!("m{material}"), surface, Vec3::splat(emission)));
        let materials = vec![material; triangles.len()];
        self.meshes.push(Mesh { positions, triangles, materials, ..Mesh::default() });
        self
    }

    /// The material of the piece added last.
    pub(super) fn last_material(&mut self) -> &mut Material {
        self.materials.last_mut().unwrap()
    }

    /// Moves the piece added last.
    pub(super) fn moving(mut self, motion: Motion) -> Self {
        self.motions.push((self.meshes.len() - 1, motion));
        self
    }

    /// A parallelogram; its front is the side `a` × `b` points to.
    pub(super) fn quad(self, corner: Vec3, a: Vec3, b: Vec3, material: (Surface, f32)) -> Self {
        let mut with =
            self.add(vec![corner, corner + a, corner + a + b, corner + b], vec![[0, 1, 2], [0, 2, 3]], material);
        with.meshes.last_mut().unwrap().uvs = vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        with
    }

    /// A unit sphere round the origin of flat triangles, scaled by `radius`; turned inside out when that is negative.
    pub(super) fn sphere(self, radius: f32, material: (Surface, f32)) -> Self {
        const ROWS: u32 = 16;
        const COLUMNS: u32 = 32;
        let vertex = |row: u32, column: u32| {
            let (sin, cos) = (std::f32::consts::PI * row as f32 / ROWS as f32).sin_cos();
            let (y, x) = (std::f32::consts::TAU * (column % COLUMNS) as f32 / COLUMNS as f32).sin_cos();
            radius.abs() * Vec3::new(sin * x, cos, sin * y)
        };
        let positions = (0..=ROWS).flat_map(|r| (0..COLUMNS).map(move |c| vertex(r, c))).collect();
        let index = |row: u32, column: u32| row * COLUMNS + column % COLUMNS;
        let mut triangles = vec![];
        for r in 0..ROWS {
            for c in 0..COLUMNS {
                triangles.push([index(r, c), index(r + 1, c + 1), index(r + 1, c)]);
                triangles.push([index(r, c), index(r, c + 1), index(r + 1, c + 1)]);
            }
        }
        // At the poles, half of them have shrunk to a line.
        let is_line = |t: &[u32; 3]| {
            let rows = t.map(|i| i / COLUMNS);
            (rows[0] == 0 && rows[1] == 0) || (rows[1] == ROWS && rows[2] == ROWS)
        };
        triangles.retain(|t| !is_line(t));
        if radius < 0.0 {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        self.add(positions, triangles, material)
    }

    pub(super) fn under(self, sky: Option<f32>) -> Scene {
        self.under_sky(sky.map(|radiance| Environment::constant(Vec3::splat(radiance))))
    }

    pub(super) fn under_sky(self, sky: Option<Environment>) -> Scene {
        let motion = |mesh| self.motions.iter().find(|(of, _)| *of == mesh).map(|(_, motion)| *motion);
        let stand = |mesh| Instance { mesh, placement: Placement::IDENTITY, motion: motion(mesh) };
        let instances = (0..self.meshes.len()).map(stand).collect();
        Scene::new(self.meshes, instances, self.materials, sky).unwrap()
    }
}

/// A diffuse sphere under a sky of radiance 1.
pub(super) fn furnace(reflectance: f32) -> Scene {
    Pieces::default().sphere(1.0, (diffuse(reflectance), 0.0)).under(Some(1.0))
}

/// A camera at (0, 3, 0) that sees the unit sphere round the origin, and some sky.
pub(super) fn looking_down(film: Size) -> Camera {
    CameraDescription::looking(Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO).on(film).unwrap()
}

/// A camera whose whole film sees one point.
pub(super) fn peering(eye: Vec3, at: Vec3) -> Camera {
    CameraDescription { fov: 0.01, ..CameraDescription::looking(eye, at) }.on(Size::new(4, 4)).unwrap()
}

/// Renders `spp` samples of every pixel.
pub(super) fn render(
    scene: &Scene,
    camera: &Camera,
    spp: u32,
    settings: &TraceSettings,
) -> (FeatureStack, TraceReport) {
    let size = camera.film;
    let mut film = Film::new(Window::whole(size), size, settings);
    let map = film.next_samples(spp);
    let report = trace(scene, camera, &mut film, &map, settings, &Silent).unwrap();
    (film.into_stack(), report)
}

/// Mean of all values of a component, and its standard error.
pub(super) fn mean_of(stack: &FeatureStack, role: ComponentRole) -> (f64, f64) {
    let estimate = &stack.component(role).unwrap().radiance;
    let values = &estimate.mean.channels()[0];
    let variance = estimate.variance_of_mean(&stack.samples).unwrap();
    let n = values.len() as f64;
    let sum = |v: &[f32]| v.iter().map(|v| f64::from(*v)).sum::<f64>();
    (sum(values) / n, sum(&variance.channels()[0]).sqrt() / n)
}

/// Asserts that the scattered light averages to `expected` within four standard errors and `slack`.
pub(super) fn assert_scattered(stack: &FeatureStack, expected: f64, slack: f64) {
    let (mean, error) = mean_of(stack, ComponentRole::Scattered);
    assert!((mean - expected).abs() < 4.0 * error + slack, "{mean} ± {error}, expected {expected}");
}

/// Sums over the picture of indirect and of gathered light, each with its variance.
pub(super) fn indirect_and_gathered(stack: &FeatureStack) -> [(f64, f64); 2] {
    [&stack.indirect, &stack.gathered].map(|light| {
        let light = light.as_ref().unwrap();
        let (values, variance) = (&light.mean.channels()[0], light.variance_of_mean(&stack.samples).unwrap());
        let sum = |v: &[f32]| v.iter().map(|v| f64::from(*v)).sum::<f64>();
        (sum(values), sum(&variance.channels()[0]))
    })
}
