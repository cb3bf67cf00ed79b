//! Rooms of chance: boxes and balls of any material under a lamp, seen through any lens. What a network learns on a few
//! scenes it knows of those; rooms show it more kinds of edges, reflections and shadows.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use glam::{Quat, Vec3};
use reconstruct::network::Numbers;

/// Writes the `number`-th room into `folder` and returns its path. What it is depends on `seed` and `number` only.
///
/// # Errors
/// When it cannot be written.
pub fn write_room(folder: &Path, seed: u64, number: u64) -> Result<PathBuf> {
    let name = format!("room-{seed}-{number}");
    let mut room = Room { numbers: Numbers::new(seed.wrapping_add(number << 32)), ..Room::default() };
    let scene = room.furnish(&name);
    let path = folder.join(format!("{name}.toml"));
    for (ending, text) in [("obj", &room.obj), ("mtl", &room.mtl), ("toml", &scene)] {
        let path = path.with_extension(ending);
        std::fs::write(&path, text).with_context(|| format!("{}: cannot write", path.display()))?;
    }
    Ok(path)
}

/// A room that is being built.
#[derive(Default)]
struct Room {
    numbers: Numbers,
    obj: String,
    mtl: String,
    vertices: usize,
    normals: usize,
    materials: usize,
}

/// Directions of a box's sides.
const AXES: [[Vec3; 3]; 6] = [
    [Vec3::X, Vec3::Y, Vec3::Z],
    [Vec3::NEG_X, Vec3::Z, Vec3::Y],
    [Vec3::Y, Vec3::Z, Vec3::X],
    [Vec3::NEG_Y, Vec3::X, Vec3::Z],
    [Vec3::Z, Vec3::X, Vec3::Y],
    [Vec3::NEG_Z, Vec3::Y, Vec3::X],
];

impl Room {
    /// Walls, lamp, furniture and camera; returns the scene file.
    fn furnish(&mut self, name: &str) -> String {
        let half = Vec3::new(self.between(1.0, 2.0), self.between(1.1, 1.5), self.between(1.3, 2.5));
        let _ = writeln!(self.obj, "mtllib {name}.mtl");
        let is_open = self.any() < 0.5;
        self.walls(half, is_open);
        self.lamp(half);
        for _ in 0..3 + (6.0 * self.any()) as usize {
            self.thing(half);
        }
        self.scene(name, half, is_open)
    }

    fn any(&mut self) -> f32 {
        0.5 + 0.5 * self.numbers.symmetric() as f32
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.any()
    }

    fn colour(&mut self) -> Vec3 {
        let bright = self.between(0.1, 0.85);
        bright * (Vec3::splat(0.4) + 0.6 * Vec3::new(self.any(), self.any(), self.any()))
    }

    /// Adds a material and returns its number: mostly matt, else coated, metal, a mirror or glass.
    fn material(&mut self, is_wall: bool) -> usize {
        let (kind, colour) = (self.any() * if is_wall { 0.75 } else { 1.0 }, self.colour());
        let Vec3 { x: r, y: g, z: b } = colour;
        let text = if kind < 0.55 {
            format!("Kd {r} {g} {b}\n")
        } else if kind < 0.7 {
            format!("Kd {r} {g} {b}\nKs 0.05 0.05 0.05\nNs {}\n", self.between(20.0, 600.0))
        } else if kind < 0.9 {
            let rough = self.between(0.05, 0.6);
            format!("Kd 0 0 0\nKs {} {} {}\nPm 1\nPr {rough}\nillum 3\n", 0.3 + 0.7 * r, 0.3 + 0.7 * g, 0.3 + 0.7 * b)
        } else {
            "Kd 0 0 0\nKs 1 1 1\nTf 1 1 1\nNi 1.5\nd 0.1\nillum 7\n".into()
        };
        self.named_material(&text)
    }

    fn named_material(&mut self, text: &str) -> usize {
        let _ = write!(self.mtl, "newmtl m{}\n{text}", self.materials);
        self.materials += 1;
        self.materials - 1
    }

    /// Floor and walls around the origin, some of them with tiles of two materials; no front wall if it `is_open`.
    fn walls(&mut self, half: Vec3, is_open: bool) {
        for side in AXES {
            if side[0] == Vec3::Z && is_open {
                continue;
            }
            let tiles = if self.any() < 0.4 { 2 + (14.0 * self.any()) as usize } else { 1 };
            let materials = [self.material(true), self.material(true)];
            // Seen from inside: the side's normal is turned round.
            let [out, along, across] = side.map(|axis| axis * half);
            let corner = out - along - across;
            let step = [across * 2.0 / tiles as f32, along * 2.0 / tiles as f32];
            for (i, j) in (0..tiles).flat_map(|i| (0..tiles).map(move |j| (i, j))) {
                let corner = corner + step[0] * i as f32 + step[1] * j as f32;
                self.quad(
                    materials[(i + j) % 2],
                    [corner, corner + step[0], corner + step[0] + step[1], corner + step[1]],
                );
            }
        }
    }

    /// A lamp under the ceiling, tiny and bright or large and dim.
    fn lamp(&mut self, half: Vec3) {
        let side = 0.6 * self.any().powi(2) + 0.04;
        let power = self.between(2.0, 8.0) / (4.0 * side * side);
        let [r, g, b] = [power * self.between(0.8, 1.2), power, power * self.between(0.6, 1.2)];
        let light = self.named_material(&format!("Kd 0 0 0\nKe {r} {g} {b}\n"));
        let place = Vec3::new(self.between(-0.5, 0.5), self.between(0.5, 0.98), self.between(-0.6, 0.4)) * half;
        let [x, z] = [Vec3::X * side, Vec3::Z * side];
        self.quad(light, [place - x - z, place + x - z, place + x + z, place - x + z]);
    }

    /// A box or a ball on the floor.
    fn thing(&mut self, half: Vec3) {
        let material = self.material(false);
        let size = Vec3::new(self.between(0.08, 0.4), self.between(0.08, 0.6), self.between(0.08, 0.4));
        let [x, z] = [self.between(-0.7, 0.7) * half.x, self.between(-0.8, 0.35) * half.z];
        if self.any() < 0.5 {
            self.ball(material, Vec3::new(x, size.x - half.y, z), size.x);
        } else {
            let turn = Quat::from_rotation_y(self.between(0.0, 3.0));
            self.cuboid(material, Vec3::new(x, size.y - half.y, z), size, turn);
        }
    }

    fn cuboid(&mut self, material: usize, centre: Vec3, half: Vec3, turn: Quat) {
        for side in AXES {
            let [out, along, across] = side.map(|axis| turn * (axis * half));
            let corners = [out - along - across, out + along - across, out + along + across, out - along + across];
            self.quad(material, corners.map(|corner| centre + corner));
        }
    }

    fn ball(&mut self, material: usize, centre: Vec3, radius: f32) {
        const AROUND: usize = 32;
        const DOWN: usize = 16;
        let (first, first_normal) = (self.vertices + 1, self.normals + 1);
        for (j, i) in (0..=DOWN).flat_map(|j| (0..AROUND).map(move |i| (j, i))) {
            let (down, around) = (j as f32 / DOWN as f32, 2.0 * i as f32 / AROUND as f32);
            let [polar, azimuth] = [down, around].map(|share| share * std::f32::consts::PI);
            let normal = Vec3::new(polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin());
            let place = centre + radius * normal;
            let _ =
                writeln!(self.obj, "v {} {} {}\nvn {} {} {}", place.x, place.y, place.z, normal.x, normal.y, normal.z);
        }
        (self.vertices, self.normals) = (self.vertices + (DOWN + 1) * AROUND, self.normals + (DOWN + 1) * AROUND);
        let _ = writeln!(self.obj, "usemtl m{material}");
        for (j, i) in (0..DOWN).flat_map(|j| (0..AROUND).map(move |i| (j, i))) {
            let at = |j: usize, i: usize| j * AROUND + i % AROUND;
            let corners = [at(j, i), at(j, i + 1), at(j + 1, i + 1), at(j + 1, i)];
            let [a, b, c, d] = corners.map(|corner| format!("{}//{}", first + corner, first_normal + corner));
            let _ = writeln!(self.obj, "f {a} {b} {c} {d}");
        }
    }

    fn quad(&mut self, material: usize, corners: [Vec3; 4]) {
        for Vec3 { x, y, z } in corners {
            let _ = writeln!(self.obj, "v {x} {y} {z}");
        }
        let first = self.vertices + 1;
        let _ = writeln!(self.obj, "usemtl m{material}\nf {} {} {} {}", first, first + 1, first + 2, first + 3);
        self.vertices += 4;
    }

    /// Camera, sky and geometry.
    fn scene(&mut self, name: &str, half: Vec3, is_open: bool) -> String {
        let away = if is_open { self.between(0.9, 1.6) } else { 0.95 };
        let eye = Vec3::new(self.between(-0.6, 0.6), self.between(-0.3, 0.6), away) * half;
        let look_at = Vec3::new(self.between(-0.4, 0.4), self.between(-0.8, 0.1), self.between(-0.8, -0.1)) * half;
        let fov = self.between(28.0, 60.0);
        let distance = (eye - look_at).length();
        let lens = if self.any() < 0.35 { self.between(0.005, 0.03) * distance } else { 0.0 };
        let focus = self.between(0.6, 1.2) * distance;
        let sky = if is_open { self.between(0.1, 1.0) } else { 0.0 };
        format!(
            "[camera]\neye = {:?}\nlook_at = {:?}\nfov = {fov:?}\nlens_radius = {lens:?}\nfocus_distance = {focus:?}\n\n\
             [environment]\ncolor = [{sky:?}, {sky:?}, {sky:?}]\n\n[[geometry]]\nfile = \"{name}.obj\"\n",
            eye.to_array(),
            look_at.to_array()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracer::scene::load;

    #[test]
    fn rooms_are_scenes_that_differ_and_can_be_made_again() {
        let folder = tempfile::tempdir().unwrap();
        let mut texts = Vec::new();
        for number in [0, 1, 2, 3, 0] {
            let path = write_room(folder.path(), 5, number).unwrap();
            let loaded = load(&path).unwrap();
            assert!(loaded.cameras[0].1.check().is_ok());
            assert!(loaded.scene.materials.iter().any(|material| material.emits()));
            texts.push(std::fs::read_to_string(path.with_extension("obj")).unwrap());
        }
        assert_eq!(texts[0], texts[4]);
        assert_ne!(texts[0], texts[1]);
    }
}
