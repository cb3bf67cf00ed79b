//! `motion`, of geometry and of cameras.

use glam::DVec3;
use serde::Deserialize;

use super::super::{Motion, SceneError};
use super::mistakes::Lines;

/// A rigid motion from time 0 to time 1 of the frame.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MotionTable {
    translate: Option<[f64; 3]>,
    /// The axis, as long as the angle in degrees.
    rotate: Option<[f64; 3]>,
    centre: Option<[f64; 3]>,
}

impl MotionTable {
    /// The motion, checked; the table begins at `offset`. It turns about `centre` unless it says otherwise.
    pub(super) fn motion(&self, centre: DVec3, offset: usize, lines: &Lines) -> Result<Motion, SceneError> {
        let motion = Motion {
            translate: self.translate.unwrap_or_default().into(),
            turn: DVec3::from(self.rotate.unwrap_or_default().map(f64::to_radians)),
            centre: self.centre.map_or(centre, DVec3::from),
        };
        let is_finite = motion.translate.is_finite() && motion.turn.is_finite() && motion.centre.is_finite();
        if is_finite { Ok(motion) } else { Err(lines.malformed(offset, "finite numbers in motion", "others")) }
    }
}
