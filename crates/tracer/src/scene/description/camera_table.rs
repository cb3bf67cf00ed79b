//! `[camera]`.

use std::ops::Range;

use glam::Vec3;
use serde::Deserialize;
use toml::Spanned;

use super::super::{Motion, SceneError};
use super::mistakes::Lines;
use super::motion_table::MotionTable;
use crate::camera::CameraDescription;

/// A camera; all but `eye` and `look_at` may be left out.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraTable {
    /// What it is called, when there are several.
    name: Option<String>,
    eye: Spanned<[f32; 3]>,
    look_at: Spanned<[f32; 3]>,
    up: Option<Spanned<[f32; 3]>>,
    fov: Option<Spanned<f32>>,
    lens_radius: Option<Spanned<f32>>,
    focus_distance: Option<Spanned<f32>>,
    shutter: Option<Spanned<[f32; 2]>>,
    motion: Option<Spanned<MotionTable>>,
}

impl CameraTable {
    /// The camera, checked.
    pub(super) fn camera(&self, lines: &Lines) -> Result<(Option<String>, CameraDescription), SceneError> {
        let plain = CameraDescription::looking((*self.eye.get_ref()).into(), (*self.look_at.get_ref()).into());
        let camera = CameraDescription {
            up: value(&self.up).map_or(plain.up, Vec3::from_array),
            fov: value(&self.fov).unwrap_or(plain.fov),
            lens_radius: value(&self.lens_radius).unwrap_or(plain.lens_radius),
            focus_distance: value(&self.focus_distance),
            shutter: value(&self.shutter).unwrap_or(plain.shutter),
            motion: self.motion(plain.eye, lines)?,
            ..plain
        };
        let refuse = |source| SceneError::Camera { place: lines.at(self.span_of(&source).start), source };
        camera.check().map_err(refuse)?;
        Ok((self.name.clone(), camera))
    }

    /// How it moves; it turns about the eye unless it says otherwise.
    fn motion(&self, eye: Vec3, lines: &Lines) -> Result<Option<Motion>, SceneError> {
        let motion = |m: &Spanned<MotionTable>| m.get_ref().motion(eye.as_dvec3(), m.span().start, lines);
        self.motion.as_ref().map(motion).transpose()
    }

    /// Where the value an error is about stands.
    fn span_of(&self, error: &crate::camera::CameraError) -> Range<usize> {
        let span = match error.what {
            "up" => self.up.as_ref().map(Spanned::span),
            "fov" => self.fov.as_ref().map(Spanned::span),
            "lens_radius" => self.lens_radius.as_ref().map(Spanned::span),
            "focus_distance" => self.focus_distance.as_ref().map(Spanned::span),
            "shutter" => self.shutter.as_ref().map(Spanned::span),
            _ => None,
        };
        span.unwrap_or(self.look_at.span())
    }
}

fn value<T: Copy>(spanned: &Option<Spanned<T>>) -> Option<T> {
    spanned.as_ref().map(|s| *s.get_ref())
}
