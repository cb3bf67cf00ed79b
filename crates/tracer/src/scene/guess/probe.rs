//! Rays that find out what a scene is like.

use glam::{Vec2, Vec3};

use super::super::Scene;
use crate::Ray;

/// How deep one sees into a scene from one side of its bounds, in shares of rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// Stopped within the first twentieth of the depth.
    pub(super) wall: f32,
    /// Stopped deeper.
    pub(super) deep: f32,
}

/// Rays along each edge of a side.
const GRID: usize = 24;

/// The four horizontal sides, by the direction from the middle to them; +z first, for that is where most boxes open.
pub(super) const HORIZONTAL: [Vec3; 4] = [Vec3::Z, Vec3::X, Vec3::NEG_Z, Vec3::NEG_X];

/// Looks into the scene from the side in the direction `outward` (along an axis).
pub(super) fn side(scene: &Scene, outward: Vec3) -> Side {
    let bounds = scene.bounds();
    let half = 0.5 * bounds.extent();
    let depth = 2.0 * half.dot(outward.abs());
    let across = outward.cross(Vec3::Y);
    let (mut wall, mut deep) = (0, 0);
    for k in 0..GRID * GRID {
        let cell = Vec2::new((k % GRID) as f32, (k / GRID) as f32);
        let at = (cell + 0.5) / GRID as f32 * 2.0 - 1.0;
        let face = bounds.centre() + half * (outward * 1.01 + across * at.x + Vec3::Y * at.y);
        match hit_distance(scene, face, -outward) {
            Some(t) if t < 0.055 * depth => wall += 1,
            Some(_) => deep += 1,
            None => {}
        }
    }
    let share = |count: i32| count as f32 / (GRID * GRID) as f32;
    Side { wall: share(wall), deep: share(deep) }
}

fn hit_distance(scene: &Scene, origin: Vec3, direction: Vec3) -> Option<f32> {
    let ray = Ray { origin, direction, t_max: f32::INFINITY, time: 0.0 };
    scene.intersect(&ray).map(|hit| hit.distance)
}

/// What one sees from a point, in shares of all directions.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Surroundings {
    /// Directions that meet a surface, of those less than 30° off the horizon.
    pub(super) level_hits: f32,
    /// Surfaces met that show their front, of all met.
    pub(super) fronts: f32,
    /// Directions that end at a lamp that shines this way.
    pub(super) lamps: f32,
    /// Directions that leave the scene.
    pub(super) open: f32,
    /// Distance to the nearest surface met.
    pub(super) clearance: f32,
}

/// Looks round from `point`, in `count` directions spread evenly (Fibonacci's lattice).
pub(super) fn look_round(scene: &Scene, point: Vec3, count: usize) -> Surroundings {
    let mut seen = Surroundings { clearance: f32::INFINITY, ..Surroundings::default() };
    let (mut level, mut hits) = (0, 0);
    for k in 0..count {
        let direction = fibonacci(k, count);
        let is_level = direction.y.abs() < 0.5;
        level += i32::from(is_level);
        let ray = Ray { origin: point, direction, t_max: f32::INFINITY, time: 0.0 };
        let Some(hit) = scene.intersect(&ray) else {
            seen.open += 1.0;
            continue;
        };
        let front = hit.geometric_normal.dot(hit.outgoing) > 0.0;
        hits += 1;
        seen.level_hits += f32::from(u8::from(is_level));
        seen.fronts += f32::from(u8::from(front));
        seen.lamps += f32::from(u8::from(front && hit.emitter.is_some()));
        seen.clearance = seen.clearance.min(hit.distance);
    }
    seen.level_hits /= level.max(1) as f32;
    seen.fronts /= hits.max(1) as f32;
    seen.lamps /= count as f32;
    seen.open /= count as f32;
    seen
}

/// Direction `k` of `count` spread evenly over the sphere.
fn fibonacci(k: usize, count: usize) -> Vec3 {
    let golden = std::f32::consts::PI * (3.0 - 5f32.sqrt());
    let y = 1.0 - (2 * k + 1) as f32 / count as f32;
    let turn = Vec2::from_angle(golden * k as f32) * (1.0 - y * y).sqrt();
    Vec3::new(turn.x, y, turn.y)
}

/// What a camera at `eye` looking along `forward` (horizontal) would show: mean over a wide view of how far one sees,
/// at most `far`; nothing for views into the open.
pub(super) fn view_depth(scene: &Scene, eye: Vec3, forward: Vec3, far: f32) -> f32 {
    const ACROSS: usize = 8;
    let right = forward.cross(Vec3::Y);
    let depth = |k: usize| {
        let at = Vec2::new((k % ACROSS) as f32 + 0.5, (k / ACROSS) as f32 + 0.5) / ACROSS as f32 * 1.4 - 0.7;
        let direction = (forward + at.x * right + at.y * Vec3::Y).normalize();
        hit_distance(scene, eye, direction).map_or(0.0, |t| t.min(far))
    };
    (0..ACROSS * ACROSS).map(depth).sum::<f32>() / (ACROSS * ACROSS) as f32
}
