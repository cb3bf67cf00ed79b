//! What to assume when nobody says where the camera stands or what the sky is.
//!
//! Rays against the scene decide, always the same ones: from outside, how deep one sees into each side ([`probe`]); from
//! inside, how much one sees from where ([`inside`]). Three cases:
//! 1. one horizontal side is open and the others are walls: a box to look into, from that side;
//! 2. the middle is surrounded by surfaces that face it, or by surfaces and lamps: a place to stand in;
//! 3. else an object, seen from outside and slightly above.

mod inside;
mod outside;
mod probe;

use glam::Vec3;

use super::Scene;
use crate::camera::CameraDescription;

/// An assumption and the sentence that says so and how to say otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Guess<T> {
    /// What is assumed.
    pub value: T,
    /// One line for the user.
    pub line: String,
}

/// Radiance of the sky where nothing emits.
const SOFT_SKY: f32 = 1.0;

/// A camera that shows what is there. Up is +y.
pub fn guess_camera(scene: &Scene) -> Guess<CameraDescription> {
    let (what, camera) = if let Some(camera) = outside::into_open_box(scene) {
        ("looking into the open box", camera)
    } else if let Some(camera) = inside::from_inside(scene) {
        ("from inside", camera)
    } else {
        ("from outside", outside::round_object(scene))
    };
    let (eye, target) = (written(camera.eye), written(camera.look_at));
    let line = format!("no camera given: {what}, as with --eye {eye} --look-at {target} --fov {}", camera.fov);
    Guess { value: camera, line }
}

/// A soft constant sky, when there is none and nothing emits more than a `glow`, the radiance that is to be looked at rather
/// than to light anything.
pub fn guess_environment(scene: &Scene, glow: f32) -> Option<Guess<Vec3>> {
    let lit = scene.emitters.iter().any(|emitter| emitter.radiance.max_element() > glow);
    let dark = scene.environment.is_none() && !lit && scene.delta_lights.is_empty();
    let why = if scene.emitters.is_empty() { "nothing emits light" } else { "nothing shines, some of it only glows" };
    let line = format!("{why}: a constant sky is assumed, as with --env {SOFT_SKY},{SOFT_SKY},{SOFT_SKY}");
    dark.then(|| Guess { value: Vec3::splat(SOFT_SKY), line })
}

/// A vector as one types it.
fn written(v: Vec3) -> String {
    v.to_array().map(|c| c.to_string()).join(",")
}

/// Rounded to three digits of `size`, so that the line can be read and retyped.
fn rounded(v: Vec3, size: f32) -> Vec3 {
    let step = 10f64.powi((f64::from(size).log10() - 3.0).floor() as i32);
    let round = |c: f32| ((f64::from(c) / step).round() * step * 1e9).round() / 1e9;
    if step.is_normal() && step > 1e-6 { Vec3::from_array(v.to_array().map(|c| round(c) as f32)) } else { v }
}

#[cfg(test)]
mod tests;
