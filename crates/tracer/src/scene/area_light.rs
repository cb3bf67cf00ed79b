//! Lamps of simple shapes, as meshes that emit.
//!
//! Round ones have flat faces. They are made a little larger than what they stand for, so that their area is right; then so is
//! their power, and by Cauchy's theorem (a convex body's shadow is a quarter of its surface on average) also how bright
//! they are from afar.

use std::f32::consts::{PI, TAU};

use glam::{DVec3, Vec2, Vec3};

use super::Mesh;
use super::mesh::cross;
use crate::material::{Colour, Material, Surface};

/// Corners of what stands for a disk.
const DISK_CORNERS: u32 = 64;

/// How often the faces of an icosahedron are cut into four to stand for a sphere: 1280 triangles.
const SPHERE_CUTS: u32 = 3;

/// A lamp that emits the same radiance everywhere, on its outside.
#[derive(Debug)]
pub(super) struct AreaLight {
    /// Its surface; material 0.
    pub(super) mesh: Mesh,
    /// Emitted radiance.
    pub(super) radiance: Vec3,
}

impl AreaLight {
    fn new(positions: Vec<Vec3>, normals: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        let materials = vec![0; triangles.len()];
        Self { mesh: Mesh { positions, normals, triangles, materials, ..Mesh::default() }, radiance: Vec3::ZERO }
    }

    /// A dark rectangle round `centre` with sides `size`, the second of which runs roughly along `up`, that faces the unit
    /// vector `facing`.
    pub(super) fn quad(centre: Vec3, facing: Vec3, up: Vec3, size: [f32; 2]) -> Self {
        let across = up.cross(facing).try_normalize().unwrap_or_else(|| facing.any_orthonormal_vector());
        let [a, b] = [0.5 * size[0] * across, 0.5 * size[1] * facing.cross(across)];
        let corners = vec![centre - a - b, centre + a - b, centre + a + b, centre - a + b];
        Self::new(corners, vec![], vec![[0, 1, 2], [0, 2, 3]])
    }

    /// A dark disk round `centre` that faces the unit vector `facing`.
    pub(super) fn disk(centre: Vec3, facing: Vec3, radius: f32) -> Self {
        let across = facing.any_orthonormal_vector();
        let along = facing.cross(across);
        let step = TAU / DISK_CORNERS as f32;
        let reach = radius * (step / step.sin()).sqrt();
        let rim = (0..DISK_CORNERS).map(|i| Vec2::from_angle(step * i as f32));
        let mut corners = vec![centre];
        corners.extend(rim.map(|p| centre + reach * (p.x * across + p.y * along)));
        let triangles = (0..DISK_CORNERS).map(|i| [0, 1 + i, 1 + (i + 1) % DISK_CORNERS]).collect();
        Self::new(corners, vec![], triangles)
    }

    /// A dark sphere round `centre`.
    pub(super) fn sphere(centre: Vec3, radius: f32) -> Self {
        let (normals, triangles) = unit_sphere();
        let sphere = Self::new(normals.clone(), normals, triangles);
        let reach = radius * (4.0 * PI / sphere.area()).sqrt();
        let positions = sphere.mesh.positions.iter().map(|p| centre + reach * p).collect();
        Self { mesh: Mesh { positions, ..sphere.mesh }, ..sphere }
    }

    /// Area, in squared scene units.
    pub(super) fn area(&self) -> f32 {
        let twice = |t: u32| cross(self.mesh.corners(t)).length();
        (0.5 * (0..self.mesh.triangles.len() as u32).map(twice).sum::<f64>()) as f32
    }

    /// What it is made of: it reflects nothing.
    pub(super) fn material(&self, name: String) -> Material {
        Material::new(name, Surface::Diffuse { reflectance: Colour::constant(Vec3::ZERO) }, self.radiance)
    }
}

/// Points on the unit sphere and triangles between them, which face outwards: an icosahedron whose faces were cut.
fn unit_sphere() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let flat = [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)];
    let mut points: Vec<DVec3> = flat.iter().map(|&(a, b)| DVec3::new(a, b, 0.0)).collect();
    points.extend(flat.iter().map(|&(a, b)| DVec3::new(0.0, a, b)));
    points.extend(flat.iter().map(|&(a, b)| DVec3::new(b, 0.0, a)));
    points.iter_mut().for_each(|p| *p = p.normalize());
    let near = |a: usize, b: usize| points[a].dot(points[b]) > 0.4 && a != b;
    let mut triangles = vec![];
    for (a, b, c) in (0..12).flat_map(|a| (a + 1..12).flat_map(move |b| (b + 1..12).map(move |c| (a, b, c)))) {
        if near(a, b) && near(b, c) && near(c, a) {
            let outwards = (points[b] - points[a]).cross(points[c] - points[a]).dot(points[a]) > 0.0;
            triangles.push(if outwards { [a, b, c] } else { [a, c, b] });
        }
    }
    for _ in 0..SPHERE_CUTS {
        let mut middles = std::collections::HashMap::new();
        let mut middle = |a: usize, b: usize| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a] + points[b]).normalize());
                points.len() - 1
            })
        };
        let cut = |&[a, b, c]: &[usize; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        triangles = triangles.iter().flat_map(cut).collect();
    }
    (points.iter().map(|p| p.as_vec3()).collect(), triangles.iter().map(|t| t.map(|v| v as u32)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_have_the_area_of_what_they_stand_for_and_face_outwards() {
        let facing = Vec3::new(0.6, -0.8, 0.0);
        let quad = AreaLight::quad(Vec3::ONE, facing, Vec3::Y, [2.0, 3.0]);
        let disk = AreaLight::disk(Vec3::ONE, facing, 0.5);
        let sphere = AreaLight::sphere(Vec3::ONE, 0.5);
        for (light, area) in [(&quad, 6.0), (&disk, PI / 4.0), (&sphere, PI)] {
            assert!((light.area() / area - 1.0).abs() < 1e-5, "{}", light.area());
        }
        let normals = |light: &AreaLight| -> Vec<(Vec3, Vec3)> {
            let of = |t| (light.mesh.corners(t), cross(light.mesh.corners(t)).normalize().as_vec3());
            (0..light.mesh.triangles.len() as u32).map(of).map(|(c, n)| ((c[0] + c[1] + c[2]) / 3.0, n)).collect()
        };
        for light in [&quad, &disk] {
            assert!(normals(light).iter().all(|(_, normal)| (normal - facing).length() < 1e-5));
        }
        assert_eq!(sphere.mesh.triangles.len(), 1280);
        assert!(normals(&sphere).iter().all(|(middle, normal)| (middle - Vec3::ONE).normalize().dot(*normal) > 0.999));
        // The second side runs along `up`, as far as the plane allows.
        let side = quad.mesh.positions[3] - quad.mesh.positions[0];
        assert!((side.length() - 3.0).abs() < 1e-5 && side.y > 0.0);
    }

    /// π L r²/d², exact for a sphere and a surface that faces it.
    #[test]
    fn a_sphere_lights_what_faces_it_like_a_point_in_its_middle() {
        let sphere = AreaLight::sphere(Vec3::ZERO, 1.5);
        for (towards, distance) in
            [(Vec3::X, 6.0), (Vec3::new(0.3, 0.7, -0.6).normalize(), 30.0), (Vec3::ONE.normalize(), 1e3)]
        {
            let receiver = (distance * towards).as_dvec3();
            let received = |t: u32| {
                let corners = sphere.mesh.corners(t);
                let span = receiver - ((corners[0] + corners[1] + corners[2]) / 3.0).as_dvec3();
                let to_receiver = span.normalize();
                let facing = 0.5 * cross(corners).dot(to_receiver).max(0.0);
                facing * to_receiver.dot(towards.as_dvec3()) / span.length_squared()
            };
            let sum: f64 = (0..sphere.mesh.triangles.len() as u32).map(received).sum();
            let expected = f64::from(PI) * 1.5 * 1.5 / f64::from(distance * distance);
            assert!((sum / expected - 1.0).abs() < 2e-3, "{distance}: {sum} {expected}");
        }
    }
}
