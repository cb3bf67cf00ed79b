//! Scenes that are like one of ours, and yet others: another camera, other colours and lights.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use glam::Vec3;
use reconstruct::network::Numbers;
use tracer::camera::CameraDescription;
use tracer::environment::Environment;
use tracer::material::Material;
use tracer::scene::{Loaded, load};

/// Writes the `number`-th variation of the scene in `file` into `folder` and returns its path. What it is depends on
/// `seed`, `number` and the scene only.
///
/// # Errors
/// When the scene cannot be read or the variation not be written.
pub fn write_variation(file: &Path, folder: &Path, seed: u64, number: u64) -> Result<PathBuf> {
    let name = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let path = folder.join(format!("{name}-{seed}-{number}.toml"));
    let text = std::fs::read_to_string(file).with_context(|| format!("{}: cannot read", file.display()))?;
    let place = file.parent().unwrap_or(Path::new("")).canonicalize().context("the scene's folder")?;
    let label = name.bytes().fold(seed, |hash, byte| hash.wrapping_mul(31).wrapping_add(byte.into()));
    let mut numbers = Numbers::new(label.wrapping_add(number << 32));
    let varied = varied(&load(file)?, &geometry_files(&text), &place, &mut numbers);
    std::fs::write(&path, varied).with_context(|| format!("{}: cannot write", path.display()))?;
    Ok(path)
}

/// The OBJ files a scene file names.
fn geometry_files(text: &str) -> Vec<&str> {
    text.lines().filter_map(|line| line.strip_prefix("file = ")).map(|name| name.trim().trim_matches('"')).collect()
}

fn varied(loaded: &Loaded, files: &[&str], place: &Path, numbers: &mut Numbers) -> String {
    let mut text = String::new();
    if let Some((_, camera)) = loaded.cameras.first() {
        text.push_str(&camera_table(&varied_camera(camera, numbers)));
    }
    if let Some(sky) = loaded.scene.environment.as_ref().and_then(Environment::constant_radiance) {
        let _ = write!(text, "[environment]\ncolor = {:?}\n\n", varied_light(sky, 1.5, numbers).to_array());
    }
    for file in files {
        let _ = write!(text, "[[geometry]]\nfile = {:?}\n\n", place.join(file).to_string_lossy());
    }
    loaded.scene.materials.iter().for_each(|material| text.push_str(&material_table(material, numbers)));
    text
}

fn camera_table(camera: &CameraDescription) -> String {
    let CameraDescription { eye, look_at, up, fov, lens_radius, focus_distance, .. } = camera;
    let [eye, look_at, up] = [eye, look_at, up].map(Vec3::to_array);
    let focus = focus_distance.map_or_else(String::new, |distance| format!("focus_distance = {distance:?}\n"));
    format!(
        "[camera]\neye = {eye:?}\nlook_at = {look_at:?}\nup = {up:?}\nfov = {fov:?}\nlens_radius = {lens_radius:?}\n{focus}\n"
    )
}

/// A camera nearer to what it looked at, and turned round it: a place that was seen before is not inside a wall.
fn varied_camera(camera: &CameraDescription, numbers: &mut Numbers) -> CameraDescription {
    let mut any = || numbers.symmetric() as f32;
    let view = camera.eye - camera.look_at;
    let distance = view.length();
    let turn = glam::Quat::from_rotation_y(0.35 * any());
    let look_at = camera.look_at + 0.15 * distance * Vec3::new(any(), 0.6 * any(), any());
    let eye = look_at + turn * view * (0.7 + 0.25 * any()) + Vec3::Y * (0.08 * distance * any());
    let fov = camera.fov * (1.0 + 0.2 * any());
    let lens = if any() > 0.4 { 0.02 * distance * (1.0 + any()) } else { camera.lens_radius };
    let focus = if lens > 0.0 { Some((eye - look_at).length() * (0.95 + 0.3 * any())) } else { camera.focus_distance };
    CameraDescription { eye, look_at, fov, lens_radius: lens, focus_distance: focus, ..*camera }
}

/// Light up to 2^`stops` times as strong or weak, of another tint.
fn varied_light(light: Vec3, stops: f32, numbers: &mut Numbers) -> Vec3 {
    let mut any = || numbers.symmetric() as f32;
    let tint = Vec3::new(1.0 + 0.3 * any(), 1.0 + 0.2 * any(), 1.0 + 0.3 * any());
    light * tint * (stops * any()).exp2()
}

/// Changes to a material: a lamp's light, or perhaps colour, roughness and coat of anything else.
fn material_table(material: &Material, numbers: &mut Numbers) -> String {
    let mut text = format!("[material.{:?}]\n", material.name);
    if material.emits() {
        let _ = write!(text, "emission = {:?}\n\n", varied_light(material.emission.factor, 1.5, numbers).to_array());
        return text;
    }
    let mut any = || 0.5 + 0.5 * numbers.symmetric() as f32;
    let (bright, colour) = (0.15 + 0.75 * any(), Vec3::new(any(), any(), any()));
    if any() < 0.25 {
        // Reflections are detail that no feature knows of: the network has to see them.
        let (base, roughness) = ((bright * (0.4 + 0.6 * colour)).to_array(), 0.05 + 0.35 * any());
        let _ = write!(text, "metallic = 1.0\nbase_color = {base:?}\nroughness = {roughness:?}\n\n");
        return text;
    }
    let (changes, roughness, is_coated) = ([any(), any()], 0.15 + 0.6 * any(), any() < 0.15);
    if changes[0] < 0.6 {
        let _ = writeln!(text, "base_color = {:?}", (bright * (0.4 + 0.6 * colour)).to_array());
    }
    if changes[1] < 0.4 {
        let _ = writeln!(text, "roughness = {roughness:?}");
    }
    if is_coated {
        text.push_str("specular = 0.04\n");
    }
    text.push('\n');
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn own(name: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name)
    }

    #[test]
    fn variations_are_scenes_that_differ_and_can_be_made_again() {
        let folder = tempfile::tempdir().unwrap();
        let text = |seed, number| {
            let path = write_variation(&own("halves.toml"), folder.path(), seed, number).unwrap();
            let loaded = load(&path).unwrap();
            assert!(loaded.scene.environment.is_some() && loaded.triangles > 100);
            (std::fs::read_to_string(path).unwrap(), loaded.cameras[0].1)
        };
        let (first, second) = (text(1, 0), text(1, 1));
        assert_eq!(first, text(1, 0));
        assert_ne!(first.1.eye, second.1.eye);
        assert_ne!(first.0, text(2, 0).0);
    }

    #[test]
    fn a_varied_camera_comes_no_further_from_what_it_sees() {
        let camera = CameraDescription::looking(Vec3::new(0.0, 1.0, 5.0), Vec3::Y);
        for seed in 0..200 {
            let found = varied_camera(&camera, &mut Numbers::new(seed));
            assert!(found.check().is_ok());
            assert!((found.eye - found.look_at).length() < 1.05 * 5.0);
        }
    }
}
