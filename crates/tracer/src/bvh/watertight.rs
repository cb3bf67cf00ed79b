//! The watertight ray/triangle test of Woop, Benthin and Wald (JCGT 2013), for one to four triangles.
//!
//! The ray is sheared onto an axis; edge functions of the sheared vertices then decide. A vertex shared by triangles
//! comes out the same in each, and the sign of a rounded difference of products is right or the difference is zero, so
//! no ray slips between neighbours. Where an edge function is zero or has left the normal range (huge or tiny scenes),
//! it is computed again in f64, where products of f32 are exact; an edge counts as hit from both sides.
//!
//! There is no least distance: a hit counts when its distance is positive. Where the rounding error of the distance
//! (bounded as in pbrt-v4, section 6.8.7) could change that sign, the distance is computed again in f64.

use glam::{DVec3, Vec3};

use crate::Ray;

/// A ray prepared for triangle tests.
#[derive(Clone, Debug)]
pub struct ShearedRay {
    pub(super) origin: [f32; 3],
    /// Axes, the last being the direction's largest, ordered to keep the winding.
    pub(super) axes: [usize; 3],
    pub(super) shear: [f32; 3],
    ray: Ray,
}

impl ShearedRay {
    /// Prepares a ray.
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let z = d.abs().max_position();
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let (x, y) = if d[z] < 0.0 { (y, x) } else { (x, y) };
        Self {
            origin: [ray.origin[x], ray.origin[y], ray.origin[z]],
            axes: [x, y, z],
            shear: [d[x] / d[z], d[y] / d[z], 1.0 / d[z]],
            ray: *ray,
        }
    }

    /// Distance to the plane of a triangle in f64, for hits too close to the origin for f32.
    pub(super) fn exact_distance(&self, vertices: [Vec3; 3]) -> f64 {
        let [a, b, c] = vertices.map(|v| v.as_dvec3());
        let normal = (b - a).cross(c - a);
        normal.dot(a - self.ray.origin.as_dvec3()) / normal.dot(self.ray.direction.as_dvec3())
    }
}

/// A hit on one triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    pub(super) distance: f32,
    /// Weights of the three vertices; their sum is 1.
    pub(super) barycentric: [f32; 3],
}

/// Sheared vertices of one triangle: x, y, z of each.
pub(super) type Sheared = [[f32; 3]; 3];

/// Decides from edge functions `edges` (of `sheared`, in f32) whether the triangle is crossed, and where.
/// `exact_distance` is asked when rounding could put a hit on the wrong side of the origin.
#[inline]
pub(super) fn decide(edges: [f32; 3], sheared: &Sheared, exact_distance: impl FnOnce() -> f64) -> Option<Crossing> {
    if edges.iter().all(|e| e.is_normal()) {
        same_sign(edges[0], edges[1], edges[2]).then_some(())?;
        let determinant = edges[0] + edges[1] + edges[2];
        let scaled = edges[0] * sheared[0][2] + edges[1] * sheared[1][2] + edges[2] * sheared[2][2];
        if determinant.is_normal() && scaled.is_normal() {
            let inverse = 1.0 / determinant;
            let distance = positive(scaled * inverse, distance_error(sheared, &edges, inverse), exact_distance)?;
            return Some(Crossing { distance, barycentric: edges.map(|e| e * inverse) });
        }
    }
    decide_exactly(sheared, exact_distance)
}

/// As [`decide`], with everything in f64.
#[cold]
fn decide_exactly(sheared: &Sheared, exact_distance: impl FnOnce() -> f64) -> Option<Crossing> {
    let [a, b, c] = sheared.map(|v| DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2])));
    let edge = |p: DVec3, q: DVec3| q.x * p.y - q.y * p.x;
    let edges = [edge(b, c), edge(c, a), edge(a, b)];
    let determinant: f64 = edges.iter().sum();
    let crossed = (edges.iter().all(|&e| e >= 0.0) || edges.iter().all(|&e| e <= 0.0)) && determinant != 0.0;
    crossed.then_some(())?;
    let distance = exact_distance();
    let barycentric = edges.map(|e| (e / determinant) as f32);
    (distance > 0.0 && distance.is_finite()).then_some(Crossing { distance: distance as f32, barycentric })
}

/// Whether three numbers, none zero, agree in sign.
#[inline]
fn same_sign(a: f32, b: f32, c: f32) -> bool {
    (a > 0.0 && b > 0.0 && c > 0.0) || (a < 0.0 && b < 0.0 && c < 0.0)
}

/// `t` when it is positive beyond doubt, else what the exact distance says.
#[inline]
fn positive(t: f32, error: f32, exact_distance: impl FnOnce() -> f64) -> Option<f32> {
    if t > error {
        return Some(t);
    }
    if t < -error {
        return None;
    }
    let exact = exact_distance();
    (exact > 0.0 && exact.is_finite()).then_some(exact as f32)
}

/// γ_n of pbrt-v4, section 6.8.1: bound of the relative error of `n` rounded operations.
const fn gamma(n: f32) -> f32 {
    let unit = 0.5 * f32::EPSILON;
    n * unit / (1.0 - n * unit)
}

/// Bound of the absolute error of the distance (pbrt-v4, section 6.8.7).
#[inline]
fn distance_error(sheared: &Sheared, edges: &[f32; 3], inverse_determinant: f32) -> f32 {
    let greatest = |axis: usize| sheared[0][axis].abs().max(sheared[1][axis].abs()).max(sheared[2][axis].abs());
    let (x, y, z) = (greatest(0), greatest(1), greatest(2));
    let error_x = const { gamma(5.0) } * (x + z);
    let error_y = const { gamma(5.0) } * (y + z);
    let error_z = const { gamma(3.0) } * z;
    let error_edge = 2.0 * (const { gamma(2.0) } * x * y + error_y * x + error_x * y);
    let edge = edges[0].abs().max(edges[1].abs()).max(edges[2].abs());
    3.0 * (const { gamma(3.0) } * edge * z + error_edge * z + error_z * edge) * inverse_determinant.abs()
}
