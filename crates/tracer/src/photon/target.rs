//! Where photons are sent: balls round all surfaces that mirror or refract.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use crate::bsdf::Frame;
use crate::bvh::Bounds;
use crate::sampler::warp::{sample_cap, sample_disc};

/// How often a ball may be split into two.
const MOST_SPLITS: u32 = 4;
/// A ball is split where its parts together show less than this share of its cross-section.
const WORTH_SPLITTING: f32 = 0.7;

/// A ball of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ball {
    centre: Vec3,
    radius: f32,
}

impl Ball {
    /// A ball round all `triangles`, of which there must be one.
    fn round(triangles: &[[Vec3; 3]]) -> Self {
        let centre = Bounds::of(triangles.iter().flatten().copied()).centre();
        let radius = triangles.iter().flatten().map(|corner| corner.distance(centre)).fold(0.0, f32::max);
        Self { centre, radius }
    }

    fn cross_section(&self) -> f32 {
        PI * self.radius * self.radius
    }

    /// 1 − the cosine of the half-angle under which it appears from `point`; 2 from within.
    fn height_from(&self, point: Vec3) -> f32 {
        let sine = self.radius * self.radius / self.centre.distance_squared(point);
        if sine >= 1.0 { 2.0 } else { sine / (1.0 + (1.0 - sine).sqrt()) }
    }

    /// Whether the line through `point` in the unit direction `direction` meets it.
    fn is_crossed(&self, point: Vec3, direction: Vec3) -> bool {
        let span = self.centre - point;
        (span - span.dot(direction) * direction).length_squared() <= self.radius * self.radius
    }

    /// Whether that half of the line does which begins at `point`.
    fn is_met(&self, point: Vec3, direction: Vec3) -> bool {
        let ahead = (self.centre - point).dot(direction) > 0.0 || self.height_from(point) == 2.0;
        ahead && self.is_crossed(point, direction)
    }
}

/// All balls.
#[derive(Debug)]
pub(super) struct Targets {
    balls: Vec<Ball>,
}

impl Targets {
    /// Balls round `triangles`; `None` when there are none.
    pub(super) fn new(mut triangles: Vec<[Vec3; 3]>) -> Option<Self> {
        let balls = if triangles.is_empty() { return None } else { split(&mut triangles, MOST_SPLITS) };
        Some(Self { balls })
    }

    /// A direction from `point` to one of them by `choice` in [0, 1) and `u` in [0, 1)², uniform over the solid angle of
    /// each, larger ones more often.
    pub(super) fn direction_from(&self, point: Vec3, choice: f32, u: Vec2) -> Vec3 {
        let heights = || self.balls.iter().map(|ball| ball.height_from(point));
        let (ball, height) = self.chosen(choice, heights);
        let towards = (ball.centre - point).try_normalize().unwrap_or(Vec3::Z);
        Frame::new(towards).to_world(sample_cap(height, u)).normalize()
    }

    /// Density of [`direction_from`](Self::direction_from) per solid angle.
    pub(super) fn direction_pdf(&self, point: Vec3, direction: Vec3) -> f32 {
        let all: f32 = self.balls.iter().map(|ball| ball.height_from(point)).sum();
        self.count(|ball| ball.is_met(point, direction)) / (2.0 * PI * all)
    }

    /// A point that rays in the unit direction `direction` go through, likewise uniform over the cross-sections.
    pub(super) fn point_across(&self, direction: Vec3, choice: f32, u: Vec2) -> Vec3 {
        let (ball, _) = self.chosen(choice, || self.balls.iter().map(Ball::cross_section));
        ball.centre + Frame::new(direction).to_world((ball.radius * sample_disc(u)).extend(0.0))
    }

    /// Density of the line through `point` there, per area across `direction`.
    pub(super) fn point_pdf(&self, point: Vec3, direction: Vec3) -> f32 {
        let all: f32 = self.balls.iter().map(Ball::cross_section).sum();
        self.count(|ball| ball.is_crossed(point, direction)) / all
    }

    fn count(&self, is_counted: impl Fn(&Ball) -> bool) -> f32 {
        self.balls.iter().filter(|ball| is_counted(ball)).count() as f32
    }

    /// One of them by `choice` in [0, 1), in proportion to its weight; and its weight.
    fn chosen<I: Iterator<Item = f32>>(&self, choice: f32, weights: impl Fn() -> I) -> (&Ball, f32) {
        let mut left = choice * weights().sum::<f32>();
        let mut last = (&self.balls[0], 0.0);
        for candidate in self.balls.iter().zip(weights()) {
            last = candidate;
            left -= candidate.1;
            if left < 0.0 {
                break;
            }
        }
        last
    }
}

/// Balls round `triangles`, split in the middle while that makes them smaller.
fn split(triangles: &mut [[Vec3; 3]], times: u32) -> Vec<Ball> {
    let whole = Ball::round(triangles);
    if times == 0 {
        return vec![whole];
    }
    let centre = |triangle: &[Vec3; 3]| triangle.iter().sum::<Vec3>() / 3.0;
    let bounds = Bounds::of(triangles.iter().map(centre));
    let axis = bounds.extent().max_position();
    let middle = bounds.centre()[axis];
    triangles.sort_by_key(|triangle| centre(triangle)[axis] >= middle);
    let first = triangles.partition_point(|triangle| centre(triangle)[axis] < middle);
    if first == 0 || first == triangles.len() {
        return vec![whole];
    }
    let (below, above) = triangles.split_at_mut(first);
    let parts = [split(below, times - 1), split(above, times - 1)].concat();
    let together: f32 = parts.iter().map(Ball::cross_section).sum();
    if together < WORTH_SPLITTING * whole.cross_section() { parts } else { vec![whole] }
}
