//! What a render's samples are, so that another run can tell whether its own may be added.

use serde::Serialize;
use serde_json::Value;
use stack::SampleCounts;
use stack::merge::{Held, Record};
use tracer::camera::CameraDescription;
use tracer::scene::{Fingerprint, Motion};

use super::View;
use crate::settings::Settings;

/// What the samples show, but for what settings say.
#[derive(Serialize)]
struct Shown {
    scene: Fingerprint,
    camera: Camera,
}

#[derive(Serialize)]
struct Camera {
    eye: [f32; 3],
    look_at: [f32; 3],
    up: [f32; 3],
    fov: f32,
    lens_radius: f32,
    focus_distance: Option<f32>,
    shutter: [f32; 2],
    motion: Option<[[f64; 3]; 3]>,
}

impl Camera {
    fn of(camera: &CameraDescription) -> Self {
        let CameraDescription { eye, look_at, up, fov, lens_radius, focus_distance, shutter, motion } = *camera;
        let motion = motion.map(|Motion { translate, turn, centre }| [translate, turn, centre].map(|v| v.to_array()));
        let [eye, look_at, up] = [eye, look_at, up].map(|v| v.to_array());
        Self { eye, look_at, up, fov, lens_radius, focus_distance, shutter, motion }
    }
}

/// All that samples depend on beside seed, number, size of the picture and crop: what the scene is, where it is seen
/// from, and how paths are traced.
pub fn view_of(view: &View, settings: &Settings) -> Value {
    let shown = Shown { scene: view.scene.fingerprint(), camera: Camera::of(view.description()) };
    // By way of text, as settings are: numbers are as short as they can be.
    let text = serde_json::to_string(&shown).unwrap_or_default();
    let mut shown: Value = serde_json::from_str(&text).unwrap_or_default();
    let mut trace = settings.to_json()["trace"].take();
    if let Some(trace) = trace.as_object_mut() {
        trace.shift_remove("seed");
    }
    shown["trace"] = trace;
    shown
}

/// The record of a film that holds `counts`.
pub fn record_of(view: &Value, seed: u64, counts: &SampleCounts) -> Record {
    let (.., most) = counts.mean_min_max();
    let held = Held { first: counts.first, end: counts.first.saturating_add(most), seed };
    Record { view: view.clone(), held: vec![held] }
}
