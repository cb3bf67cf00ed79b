//! `[camera]`.

use glam::Vec3;

use super::super::{Motion, SceneError};
use super::keys::{TomlTable, toml_table};
use super::mistakes::Lines;
use super::motion_table::MotionTable;
use crate::camera::CameraDescription;

/// What is assumed of a camera that says nothing but where it stands.
const USUAL: CameraDescription = CameraDescription::looking(Vec3::ZERO, Vec3::NEG_Z);

toml_table! {
    /// A camera.
    pub(super) struct CameraTable {
        /// what `--camera` asks for
        optional name: String = "none";
        /// centre of the lens
        required eye: [f32; 3];
        /// the middle of the picture; not the eye
        required look_at: [f32; 3];
        /// roughly up; a camera that looks along it gets some other one
        default up: [f32; 3] = USUAL.up.to_array();
        /// *vertical* field of view, between 0 and 180, both excluded
        default fov: f32 = USUAL.fov;
        /// 0 is a pinhole
        default lens_radius: f32 = USUAL.lens_radius;
        /// distance of the plane in focus along the view, above 0
        optional focus_distance: f32 = "distance to `look_at`";
        /// opening and closing, in order, within the frame, whose time runs from 0 to 1
        default shutter: [f32; 2] = USUAL.shutter;
        /// how the camera moves over the frame, as geometry does; it turns about the eye
        optional motion: MotionTable = "none";
    }
}

impl CameraTable {
    /// The camera, checked.
    pub(super) fn camera(&self, lines: &Lines) -> Result<(Option<String>, CameraDescription), SceneError> {
        let camera = CameraDescription {
            eye: (*self.eye()).into(),
            look_at: (*self.look_at()).into(),
            up: self.up().into(),
            fov: self.fov(),
            lens_radius: self.lens_radius(),
            focus_distance: self.focus_distance().copied(),
            shutter: self.shutter(),
            motion: self.described_motion(lines)?,
        };
        let place = |key| lines.at(self.place_of(key).unwrap_or(self.look_at.span().start));
        camera.check().map_err(|source| SceneError::Camera { place: place(source.what), source })?;
        Ok((self.name().cloned(), camera))
    }

    /// How it moves; it turns about the eye unless it says otherwise.
    fn described_motion(&self, lines: &Lines) -> Result<Option<Motion>, SceneError> {
        let eye = Vec3::from_array(*self.eye()).as_dvec3();
        self.motion().map(|motion| motion.motion(eye, lines)).transpose()
    }
}
