//! A room to measure in where no scene is given: a lamp, a rough metal ball and a dull one in an open box.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use tracer::camera::CameraDescription;
use tracer::material::{Colour, Material, Surface};
use tracer::scene::{Instance, Mesh, Placement, Scene, SceneError};

/// Segments round a ball.
const SEGMENTS: u32 = 256;

/// The meshes of the room, each with its own material.
pub fn meshes() -> Vec<Mesh> {
    let corner = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let [a, b, c, d] = [corner(-1.0, 0.0, -1.0), corner(1.0, 0.0, -1.0), corner(1.0, 0.0, 1.0), corner(-1.0, 0.0, 1.0)];
    let up = 2.0 * Vec3::Y;
    let mut walls = Mesh::default();
    for [p, q, r, s] in [[d, c, b, a], [a, b, b + up, a + up], [d, a, a + up, d + up], [b, c, c + up, b + up]] {
        add_quad(&mut walls, [p, q, r, s]);
    }
    add_quad(&mut walls, [a, b, c, d].map(|v| v + up));
    let mut lamp = Mesh::default();
    add_quad(&mut lamp, [a, b, c, d].map(|v| 0.25 * v + 0.99 * up));
    let mut all = vec![walls, lamp, ball(corner(-0.4, 0.4, -0.3), 0.4), ball(corner(0.45, 0.35, 0.3), 0.35)];
    for (mesh, material) in all.iter_mut().zip(0..) {
        mesh.materials = vec![material; mesh.triangles.len()];
    }
    all
}

/// The scene of the `meshes`.
///
/// # Errors
/// Never, but for a mistake here.
pub fn scene(meshes: Vec<Mesh>) -> Result<Scene, SceneError> {
    let grey = |v: f32| Colour::constant(Vec3::splat(v));
    let dull = |v: f32| Surface::Diffuse { reflectance: grey(v) };
    let materials = vec![
        Material::new("walls", dull(0.7), Vec3::ZERO),
        Material::new("lamp", dull(0.0), Vec3::splat(12.0)),
        Material::new("metal", Surface::Conductor { reflectance: grey(0.9), alpha: 0.1 }, Vec3::ZERO),
        Material::new("dull", dull(0.4), Vec3::ZERO),
    ];
    let stand = |mesh: usize| Instance { mesh, placement: Placement::IDENTITY, motion: None };
    let instances = (0..meshes.len()).map(stand).collect();
    Scene::new(meshes, instances, materials, None)
}

/// A camera that looks into it.
pub const CAMERA: CameraDescription = CameraDescription::looking(Vec3::new(0.0, 1.0, 3.8), Vec3::new(0.0, 0.9, 0.0));

fn add_quad(mesh: &mut Mesh, corners: [Vec3; 4]) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(corners);
    mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|triangle: [u32; 3]| triangle.map(|corner| first + corner)));
}

fn ball(centre: Vec3, radius: f32) -> Mesh {
    let rows = SEGMENTS / 2;
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=SEGMENTS {
            let angles = PI * Vec2::new(2.0 * column as f32 / SEGMENTS as f32, row as f32 / rows as f32);
            let (along, down) = (Vec2::from_angle(angles.x), Vec2::from_angle(angles.y));
            let normal = Vec3::new(down.y * along.x, down.x, -down.y * along.y);
            mesh.positions.push(centre + radius * normal);
            mesh.normals.push(normal);
        }
    }
    for row in 0..rows {
        for column in 0..SEGMENTS {
            let [above, below] = [row, row + 1].map(|row| row * (SEGMENTS + 1) + column);
            mesh.triangles.extend([[above, below, below + 1], [above, below + 1, above + 1]]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracer::Ray;

    #[test]
    fn the_camera_sees_the_balls_from_outside_them_and_the_lamp_shines_down() {
        let scene = scene(meshes()).unwrap();
        assert!(scene.triangles() > 100_000 && scene.emitters.len() == 2);
        assert!(scene.emitters.iter().all(|lamp| lamp.normal.y < -0.99));
        let looking = |from: Vec3, to: Vec3| {
            let ray = Ray { origin: from, direction: (to - from).normalize(), t_max: f32::INFINITY, time: 0.0 };
            scene.intersect(&ray).map(|hit| hit.distance)
        };
        let eye = CAMERA.eye;
        for (centre, radius) in [(Vec3::new(-0.4, 0.4, -0.3), 0.4), (Vec3::new(0.45, 0.35, 0.3), 0.35)] {
            let distance = looking(eye, centre).unwrap();
            assert!((distance - ((centre - eye).length() - radius)).abs() < 1e-3, "{distance}");
        }
        assert!(looking(eye, eye + Vec3::Z).is_none(), "open towards the camera");
    }
}
