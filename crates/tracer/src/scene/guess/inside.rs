//! Cameras inside.

use glam::{Vec2, Vec3};

use super::super::Scene;
use super::probe::{Surroundings, look_round, view_depth};
use super::rounded;
use crate::camera::CameraDescription;

/// Field of view in a room.
const ROOM_FOV: f32 = 60.0;

/// Directions looked into from each place.
const DIRECTIONS: usize = 128;

/// Places tried along x, y, z.
const PLACES: [usize; 3] = [7, 3, 7];

/// Headings tried.
const HEADINGS: usize = 12;

/// A camera in the place and direction from which one sees farthest, when the scene surrounds its middle.
pub(super) fn from_inside(scene: &Scene) -> Option<CameraDescription> {
    let bounds = scene.bounds();
    let size = bounds.diagonal();
    let around = look_round(scene, bounds.centre(), DIRECTIONS);
    let places: Vec<Vec3> = places(scene).collect();
    let is_place = |&&p: &&Vec3| is_room(&look_round(scene, p, DIRECTIONS), size);
    let rooms: Vec<Vec3> = places.iter().filter(is_place).copied().collect();
    // The middle itself may lie in a table or a column; then its neighbourhood decides.
    if !is_room(&around, size) && 3 * rooms.len() < places.len() {
        return None;
    }
    let views = rooms.iter().flat_map(|&eye| (0..HEADINGS).map(move |heading| (eye, heading)));
    let judged = views.map(|(eye, heading)| (view_depth(scene, eye, forward(heading), 0.5 * size), eye, heading));
    let (_, eye, heading) = judged.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let eye = rounded(eye, size);
    let target = rounded(eye + 0.25 * size * (forward(heading) - 0.08 * Vec3::Y), size);
    Some(CameraDescription { fov: ROOM_FOV, ..CameraDescription::looking(eye, target) })
}

/// Whether one stands in a place to be: surrounded, not in the solid, not with the nose to a wall. Within a solid
/// object all surfaces show their backs; a building whose walls show their backs still has lamps or windows.
fn is_room(seen: &Surroundings, size: f32) -> bool {
    let surrounded = seen.level_hits > 0.9;
    let windows = seen.open > 0.003 && seen.open < 0.4;
    surrounded
        && seen.clearance > 0.01 * size
        && (seen.fronts > 0.6 || seen.lamps > 0.0 || (windows && seen.fronts > 0.25))
}

fn forward(heading: usize) -> Vec3 {
    let turn = Vec2::from_angle(std::f32::consts::TAU * heading as f32 / HEADINGS as f32);
    Vec3::new(turn.x, 0.0, turn.y)
}

/// A grid over the middle of the bounds.
fn places(scene: &Scene) -> impl Iterator<Item = Vec3> {
    let bounds = scene.bounds();
    let [nx, ny, nz] = PLACES;
    (0..nx * ny * nz).map(move |k| {
        let cell = Vec3::new((k % nx) as f32, (k / nx % ny) as f32, (k / (nx * ny)) as f32);
        bounds.min + bounds.extent() * (cell + 1.0) / (Vec3::new(nx as f32, ny as f32, nz as f32) + 1.0)
    })
}
