//! Rigid motion while the shutter is open.

use glam::{DAffine3, DQuat, DVec3};

/// A rigid motion, even over the frame, whose time runs from 0 to 1: a turn about a point, then a shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// How far it goes over the whole frame, in scene units.
    pub translate: DVec3,
    /// The axis of the turn, as long as the angle over the whole frame, in radians; several turns are possible.
    pub turn: DVec3,
    /// The point that only the shift moves.
    pub centre: DVec3,
}

impl Motion {
    /// The map from where things are at time 0 to where they are at `time`.
    pub fn at(&self, time: f32) -> DAffine3 {
        let share = f64::from(time);
        let turn = DAffine3::from_quat(DQuat::from_scaled_axis(share * self.turn));
        let back = DAffine3::from_translation(self.centre + share * self.translate);
        back * turn * DAffine3::from_translation(-self.centre)
    }

    /// How far a point `distance` away from the centre can be from the straight line between its places at two moments
    /// that are the share `step` of the frame apart: the height of an arc over its chord.
    pub(crate) fn bulge(&self, step: f64, distance: f64) -> f64 {
        distance * (1.0 - (0.5 * step * self.turn.length()).min(std::f64::consts::PI).cos())
    }
}
