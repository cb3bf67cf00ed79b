//! Up to four triangles tested together.

use glam::Vec3;

use super::Placement;
use super::node::LANES;
use super::watertight::{Crossing, Sheared, ShearedRay, decide};

/// Up to four triangles: coordinates by vertex, axis and lane. Lanes beyond `count` repeat the first triangle.
#[derive(Clone, Debug)]
#[repr(align(16))]
pub(super) struct Packet {
    vertices: [[[f32; LANES]; 3]; 3],
    triangles: [u32; LANES],
    count: u32,
}

impl Packet {
    /// Packs the triangles numbered `members`, at least one and at most four.
    pub(super) fn new(members: &[u32], vertices_of: impl Fn(u32) -> [Vec3; 3]) -> Self {
        let member = |lane: usize| members[if lane < members.len() { lane } else { 0 }];
        let corners: [[Vec3; 3]; LANES] = std::array::from_fn(|lane| vertices_of(member(lane)));
        let coordinate = |vertex: usize, axis: usize| std::array::from_fn(|lane| corners[lane][vertex][axis]);
        Self {
            vertices: std::array::from_fn(|vertex| std::array::from_fn(|axis| coordinate(vertex, axis))),
            triangles: std::array::from_fn(member),
            count: members.len() as u32,
        }
    }

    /// The packet moved to the scene.
    pub(super) fn placed(&self, placement: &Placement) -> Self {
        let place = |v: &[[f32; LANES]; 3], axis| {
            std::array::from_fn(|lane| placement.coordinate(axis, v[0][lane], v[1][lane], v[2][lane]))
        };
        Self { vertices: self.vertices.map(|v| std::array::from_fn(|axis| place(&v, axis))), ..*self }
    }

    /// Calls `found` with the number and crossing of each triangle the ray crosses.
    #[inline]
    pub(super) fn crossings(&self, ray: &ShearedRay, mut found: impl FnMut(u32, Crossing)) {
        let sheared = self.shear(ray);
        let edges = edge_functions(&sheared);
        let missed = missed(&edges);
        for lane in (0..self.count as usize).filter(|&lane| !missed[lane]) {
            let of_lane: Sheared = std::array::from_fn(|v| std::array::from_fn(|axis| sheared[v][axis][lane]));
            let exact = || ray.exact_distance(self.corners(lane));
            if let Some(crossing) = decide(std::array::from_fn(|v| edges[v][lane]), &of_lane, exact) {
                found(self.triangles[lane], crossing);
            }
        }
    }

    fn corners(&self, lane: usize) -> [Vec3; 3] {
        self.vertices.map(|v| Vec3::new(v[0][lane], v[1][lane], v[2][lane]))
    }

    /// Vertices relative to the ray's origin, sheared so that the ray runs along the last axis.
    #[inline]
    fn shear(&self, ray: &ShearedRay) -> [[[f32; LANES]; 3]; 3] {
        let mut sheared = [[[0.0; LANES]; 3]; 3];
        for (out, vertex) in sheared.iter_mut().zip(&self.vertices) {
            let (x, y, z) = (&vertex[ray.axes[0]], &vertex[ray.axes[1]], &vertex[ray.axes[2]]);
            for lane in 0..LANES {
                let depth = z[lane] - ray.origin[2];
                out[0][lane] = x[lane] - ray.origin[0] - ray.shear[0] * depth;
                out[1][lane] = y[lane] - ray.origin[1] - ray.shear[1] * depth;
                out[2][lane] = ray.shear[2] * depth;
            }
        }
        sheared
    }
}

/// The edge function opposite each vertex.
#[inline]
fn edge_functions(v: &[[[f32; LANES]; 3]; 3]) -> [[f32; LANES]; 3] {
    let mut edges = [[0.0; LANES]; 3];
    for (i, edge) in edges.iter_mut().enumerate() {
        let (p, q) = (&v[(i + 1) % 3], &v[(i + 2) % 3]);
        for lane in 0..LANES {
            edge[lane] = q[0][lane] * p[1][lane] - q[1][lane] * p[0][lane];
        }
    }
    edges
}

/// Which triangles are missed beyond doubt: edge functions of both signs, both above what underflow can turn round.
#[inline]
fn missed(edges: &[[f32; LANES]; 3]) -> [bool; LANES] {
    let mut missed = [false; LANES];
    for lane in 0..LANES {
        let (a, b, c) = (edges[0][lane], edges[1][lane], edges[2][lane]);
        let negative = (a < -f32::MIN_POSITIVE) | (b < -f32::MIN_POSITIVE) | (c < -f32::MIN_POSITIVE);
        let positive = (a > f32::MIN_POSITIVE) | (b > f32::MIN_POSITIVE) | (c > f32::MIN_POSITIVE);
        missed[lane] = negative & positive;
    }
    missed
}
