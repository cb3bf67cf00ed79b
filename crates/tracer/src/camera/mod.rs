//! From film to rays: pinhole and thin lens.

mod description;

use glam::{Vec2, Vec3};
use stack::Size;

pub use description::{CameraDescription, CameraError};

use crate::Ray;
use crate::motion::Motion;
use crate::sampler::warp::sample_disc;

/// A camera with its film. A lens radius of zero makes it a pinhole.
///
/// [`CameraDescription::on`] makes one from checked values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Centre of the lens.
    pub eye: Vec3,
    /// A point in the middle of the picture.
    pub look_at: Vec3,
    /// Which way is up in the picture, roughly.
    pub up: Vec3,
    /// Vertical field of view, in degrees.
    pub fov: f32,
    /// Radius of the lens, in scene units.
    pub lens_radius: f32,
    /// Distance of the plane in focus from the eye, along the view, in scene units.
    pub focus_distance: f32,
    /// When the shutter opens and closes, within the frame 0 … 1.
    pub shutter: [f32; 2],
    /// How it moves; what is above holds at time 0.
    pub motion: Option<Motion>,
    /// Pixels of the film.
    pub film: Size,
}

impl Camera {
    /// The ray through `film`, as of [`rays`](Self::rays), of which one is enough.
    pub fn ray(&self, film: Vec2, lens: Vec2, time: f32) -> Ray {
        self.rays().ray(film, lens, time)
    }

    /// What sends rays through the film.
    pub fn rays(&self) -> CameraRays<'_> {
        CameraRays { camera: self, frame: self.frame(), half_pixel: 0.5 * self.pixel_width() }
    }

    /// Width of a pixel in the middle of the picture, at distance 1 from the eye.
    pub(crate) fn pixel_width(&self) -> f32 {
        2.0 * (0.5 * self.fov.to_radians()).tan() / self.film.height as f32
    }

    /// Unit vectors to the right, up and forward.
    fn frame(&self) -> [Vec3; 3] {
        let forward = (self.look_at - self.eye).normalize();
        let right = forward.cross(self.up).normalize();
        [right, right.cross(forward), forward]
    }
}

/// A camera ready to send rays: what they share is computed once.
#[derive(Clone, Copy, Debug)]
pub struct CameraRays<'a> {
    camera: &'a Camera,
    /// Unit vectors to the right, up and forward.
    frame: [Vec3; 3],
    /// Half of a pixel's width at distance 1.
    half_pixel: f32,
}

impl CameraRays<'_> {
    /// The ray through `film` (continuous pixel coordinates, (0, 0) the top left corner) from point `lens` ([0, 1)²) of
    /// the lens, at share `time` (0 … 1) of the shutter interval.
    #[inline]
    pub fn ray(&self, film: Vec2, lens: Vec2, time: f32) -> Ray {
        let Self { camera, frame: [right, up, forward], half_pixel } = *self;
        let size = Vec2::new(camera.film.width as f32, camera.film.height as f32);
        let plane = (2.0 * film - size) * half_pixel;
        let through = plane.x * right - plane.y * up + forward;
        let on_lens = camera.lens_radius * sample_disc(lens);
        let offset = on_lens.x * right + on_lens.y * up;
        let direction = if camera.lens_radius > 0.0 { camera.focus_distance * through - offset } else { through };
        let time = camera.shutter[0] + time * (camera.shutter[1] - camera.shutter[0]);
        let (origin, direction) = (camera.eye + offset, direction.normalize());
        let Some(motion) = &camera.motion else { return Ray { origin, direction, t_max: f32::INFINITY, time } };
        let map = motion.at(time);
        let origin = map.transform_point3(origin.as_dvec3()).as_vec3();
        let direction = map.transform_vector3(direction.as_dvec3()).normalize().as_vec3();
        Ray { origin, direction, t_max: f32::INFINITY, time }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn description() -> CameraDescription {
        CameraDescription {
            fov: 90.0,
            ..CameraDescription::looking(Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.0, 2.0, -7.0))
        }
    }

    fn close(a: Vec3, b: Vec3) -> bool {
        (a - b).length() < 1e-6
    }

    #[test]
    fn a_pinhole_looks_through_the_middle_and_the_corners() {
        let camera = description().on(Size::new(200, 100)).unwrap();
        let middle = camera.ray(Vec2::new(100.0, 50.0), Vec2::ZERO, 0.0);
        assert_eq!(middle.origin, Vec3::new(1.0, 2.0, 3.0));
        assert!(close(middle.direction, -Vec3::Z));
        let corner = camera.ray(Vec2::ZERO, Vec2::splat(0.3), 0.0).direction;
        assert!(close(corner, Vec3::new(-2.0, 1.0, -1.0).normalize()));
        let bottom = camera.ray(Vec2::new(100.0, 100.0), Vec2::ZERO, 0.0).direction;
        assert!(close(bottom, Vec3::new(0.0, -1.0, -1.0).normalize()));
    }

    #[test]
    fn all_points_of_the_lens_see_the_same_point_in_the_plane_of_focus() {
        let thin = CameraDescription { lens_radius: 0.5, focus_distance: Some(4.0), ..description() };
        let (camera, pinhole) = (thin.on(Size::new(64, 64)).unwrap(), description().on(Size::new(64, 64)).unwrap());
        let film = Vec2::new(10.0, 50.0);
        let central = pinhole.ray(film, Vec2::ZERO, 0.0);
        let target = central.at(4.0 / -central.direction.z);
        for i in 0..64 {
            let ray = camera.ray(film, Vec2::new((i % 8) as f32 / 8.0, (i / 8) as f32 / 8.0), 0.0);
            assert!((ray.origin - camera.eye).length() <= 0.5 + 1e-6);
            assert!(((ray.at((target - ray.origin).length())) - target).length() < 1e-5);
        }
    }

    #[test]
    fn the_plane_of_focus_goes_through_the_point_looked_at_unless_told_otherwise() {
        assert_eq!(description().on(Size::new(8, 8)).unwrap().focus_distance, 10.0);
    }

    #[test]
    fn a_moving_camera_is_at_any_moment_where_one_would_stand() {
        let turn = glam::DVec3::Y * std::f64::consts::FRAC_PI_2;
        let motion = Motion { translate: glam::DVec3::X, turn, centre: glam::DVec3::new(1.0, 2.0, 3.0) };
        let moving = CameraDescription { motion: Some(motion), ..description() }.on(Size::new(64, 64)).unwrap();
        let still =
            CameraDescription { eye: Vec3::new(2.0, 2.0, 3.0), look_at: Vec3::new(-8.0, 2.0, 3.0), ..description() };
        let still = still.on(Size::new(64, 64)).unwrap();
        let (a, b) =
            (moving.ray(Vec2::new(9.0, 50.0), Vec2::ZERO, 1.0), still.ray(Vec2::new(9.0, 50.0), Vec2::ZERO, 1.0));
        assert!(close(a.origin, b.origin) && close(a.direction, b.direction), "{a:?} {b:?}");
    }

    #[test]
    fn time_runs_over_the_shutter_interval() {
        let camera = CameraDescription { shutter: [0.25, 0.75], ..description() }.on(Size::new(8, 8)).unwrap();
        let at = |time| camera.ray(Vec2::ZERO, Vec2::ZERO, time).time;
        assert_eq!([at(0.0), at(0.5), at(1.0)], [0.25, 0.5, 0.75]);
    }
}
