//! `motion`, of geometry and of cameras.

use glam::DVec3;

use super::super::{Motion, SceneError};
use super::keys::{FINITE, TomlTable, TomlValue, toml_table};
use super::mistakes::Lines;

toml_table! {
    /// A rigid motion from time 0 to time 1 of the frame.
    pub(super) struct MotionTable {
        /// the axis of an even turn, as long as the angle over the frame in degrees; several turns are possible
        default rotate: [f64; 3] = [0.0; 3], FINITE;
        /// the point that the turn leaves in its place
        optional centre: [f64; 3] = "where `transform` takes the origin", FINITE;
        /// how far it goes over the frame
        default translate: [f64; 3] = [0.0; 3], FINITE;
    }
}

impl TomlValue for MotionTable {
    fn kind() -> String {
        "table".into()
    }
}

impl MotionTable {
    /// The motion, checked. It turns about `centre` unless it says otherwise.
    pub(super) fn motion(&self, centre: DVec3, lines: &Lines) -> Result<Motion, SceneError> {
        self.check(lines)?;
        Ok(Motion {
            translate: self.translate().into(),
            turn: DVec3::from(self.rotate().map(f64::to_radians)),
            centre: self.centre().map_or(centre, |&centre| centre.into()),
        })
    }
}
