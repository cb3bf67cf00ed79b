//! What a scene file or a command says about a camera, before there is a film.

use glam::Vec3;
use stack::{Fault, Size};

use super::Camera;
use crate::motion::Motion;

/// A camera without its film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraDescription {
    /// Centre of the lens.
    pub eye: Vec3,
    /// A point in the middle of the picture.
    pub look_at: Vec3,
    /// Which way is up in the picture, roughly.
    pub up: Vec3,
    /// Vertical field of view, in degrees, between 0 and 180.
    pub fov: f32,
    /// Radius of the lens, in scene units; zero for a pinhole.
    pub lens_radius: f32,
    /// Distance of the plane in focus, in scene units; that of `look_at` when absent.
    pub focus_distance: Option<f32>,
    /// When the shutter opens and closes, within the frame 0 … 1.
    pub shutter: [f32; 2],
    /// How it moves; what is above holds at time 0.
    pub motion: Option<Motion>,
}

impl CameraDescription {
    /// A pinhole at `eye` that looks at `look_at`, up being +y, with a field of view of 45° and an open shutter.
    pub const fn looking(eye: Vec3, look_at: Vec3) -> Self {
        Self {
            eye,
            look_at,
            up: Vec3::Y,
            fov: 45.0,
            lens_radius: 0.0,
            focus_distance: None,
            shutter: [0.0, 1.0],
            motion: None,
        }
    }

    /// Puts a film into the camera.
    ///
    /// # Errors
    /// When eye and target coincide, a value is out of range or not finite, or the film has no pixel. A camera that
    /// looks straight along `up` is turned to some other up instead.
    pub fn on(&self, film: Size) -> Result<Camera, CameraError> {
        self.check()?;
        if film.pixels() == 0 {
            return Err(CameraError { what: "film", found: film.to_string(), expected: "at least one pixel" });
        }
        let view = self.look_at - self.eye;
        let straight = view.normalize().cross(self.up.normalize()).length_squared() < f32::EPSILON;
        Ok(Camera {
            eye: self.eye,
            look_at: self.look_at,
            up: if straight { view.normalize().any_orthonormal_vector() } else { self.up },
            fov: self.fov,
            lens_radius: self.lens_radius,
            focus_distance: self.focus_distance.unwrap_or(view.length()),
            shutter: self.shutter,
            motion: self.motion,
            film,
        })
    }

    /// Checks everything that does not depend on the film.
    ///
    /// # Errors
    /// As [`on`](Self::on).
    pub fn check(&self) -> Result<(), CameraError> {
        let refuse = |what, found: String, expected| Err(CameraError { what, found, expected });
        let view = self.look_at - self.eye;
        if !(view.is_finite() && self.eye.is_finite() && view.length_squared().is_normal()) {
            return refuse("look_at", self.look_at.to_string(), "a point away from the eye");
        }
        if !self.up.length_squared().is_normal() {
            return refuse("up", self.up.to_string(), "a direction");
        }
        if !(self.fov > 0.0 && self.fov < 180.0) {
            return refuse("fov", self.fov.to_string(), "degrees between 0 and 180");
        }
        if !(self.lens_radius >= 0.0 && self.lens_radius.is_finite()) {
            return refuse("lens_radius", self.lens_radius.to_string(), "0 or more");
        }
        if let Some(distance) = self.focus_distance.filter(|d| !(*d > 0.0 && d.is_finite())) {
            return refuse("focus_distance", distance.to_string(), "more than 0");
        }
        let [open, close] = self.shutter;
        if !(0.0 <= open && open <= close && close <= 1.0) {
            return refuse("shutter", format!("[{open}, {close}]"), "two moments in order, from 0 to 1");
        }
        Ok(())
    }
}

/// A camera value out of range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("camera {what}: found {found}, expected {expected}")]
pub struct CameraError {
    /// Which value.
    pub what: &'static str,
    /// What it is.
    pub found: String,
    /// What it should be.
    pub expected: &'static str,
}

impl CameraError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        Fault::Usage
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_out_of_range_are_refused_by_name() {
        let good = CameraDescription::looking(Vec3::ZERO, Vec3::X);
        let film = Size::new(4, 4);
        assert!(good.on(film).is_ok());
        let refused = |camera: CameraDescription, film| camera.on(film).unwrap_err().what;
        assert_eq!(refused(CameraDescription { look_at: Vec3::ZERO, ..good }, film), "look_at");
        assert_eq!(refused(CameraDescription { eye: Vec3::NAN, ..good }, film), "look_at");
        assert_eq!(refused(CameraDescription { up: Vec3::ZERO, ..good }, film), "up");
        assert_eq!(refused(CameraDescription { fov: 180.0, ..good }, film), "fov");
        assert_eq!(refused(CameraDescription { fov: f32::NAN, ..good }, film), "fov");
        assert_eq!(refused(CameraDescription { lens_radius: -1.0, ..good }, film), "lens_radius");
        assert_eq!(refused(CameraDescription { focus_distance: Some(0.0), ..good }, film), "focus_distance");
        assert_eq!(refused(CameraDescription { shutter: [0.5, 0.2], ..good }, film), "shutter");
        assert_eq!(refused(good, Size::new(0, 4)), "film");
    }

    #[test]
    fn looking_straight_up_still_makes_a_camera() {
        let camera = CameraDescription::looking(Vec3::ZERO, Vec3::Y).on(Size::new(4, 4)).unwrap();
        assert!(camera.ray(glam::Vec2::ONE, glam::Vec2::ZERO, 0.0).direction.is_finite());
    }
}
