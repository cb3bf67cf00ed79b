//! Where a mesh stands: an affine map.

use glam::{DAffine3, DMat3, Vec3};

/// An invertible affine map from a mesh's own space to the scene's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Rows of the linear part, each followed by its translation.
    rows: [[f32; 4]; 3],
    inverse: [[f32; 4]; 3],
    mirrored: bool,
}

impl Placement {
    /// The map that changes nothing.
    pub const IDENTITY: Self = {
        let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        Self { rows, inverse: rows, mirrored: false }
    };

    /// Takes a map, unless it or its inverse is not finite in f32.
    pub fn new(map: DAffine3) -> Option<Self> {
        let inverse = map.inverse();
        let determinant = map.matrix3.determinant();
        let [rows, inverse] = [map, inverse].map(|map| rows_of(&map));
        let sound = determinant != 0.0 && [rows, inverse].as_flattened().as_flattened().iter().all(|n| n.is_finite());
        sound.then_some(Self { rows, inverse, mirrored: determinant < 0.0 })
    }

    /// The map.
    pub fn map(&self) -> DAffine3 {
        let column = |i: usize| glam::DVec3::from_array(self.rows.map(|row| f64::from(row[i])));
        DAffine3::from_cols(column(0), column(1), column(2), column(3))
    }

    /// Whether it turns left hands into right hands.
    pub fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// Where the point `(x, y, z)` comes to lie along `axis`. The same sum for every caller, so that vertices shared by
    /// triangles stay shared.
    #[inline]
    pub fn coordinate(&self, axis: usize, x: f32, y: f32, z: f32) -> f32 {
        let [a, b, c, d] = self.rows[axis];
        a * x + b * y + c * z + d
    }

    /// Where a point comes to lie.
    #[inline]
    pub fn point(&self, p: Vec3) -> Vec3 {
        Vec3::new(
            self.coordinate(0, p.x, p.y, p.z),
            self.coordinate(1, p.x, p.y, p.z),
            self.coordinate(2, p.x, p.y, p.z),
        )
    }

    /// Where a normal points, not normalised: by the inverse transpose.
    #[inline]
    pub fn normal(&self, n: Vec3) -> Vec3 {
        let [a, b, c] = self.inverse;
        n.x * row(a) + n.y * row(b) + n.z * row(c)
    }

    /// Where a point of the scene lies in the mesh's space.
    #[inline]
    pub fn inverse_point(&self, p: Vec3) -> Vec3 {
        self.inverse_direction(p) + Vec3::from_array(self.inverse.map(|r| r[3]))
    }

    /// A direction of the scene in the mesh's space; its length changes, so distances along it do not.
    #[inline]
    pub fn inverse_direction(&self, v: Vec3) -> Vec3 {
        Vec3::from_array(self.inverse.map(|r| row(r).dot(v)))
    }

    /// Bound of the error, along any axis of the mesh's space, made by taking a ray there and by testing it against
    /// vertices taken to the scene, when nothing in the scene is further from its origin than `reach`.
    pub(super) fn inverse_error(&self, reach: f32) -> f32 {
        let magnitude = |r: [f32; 4]| row(r).abs().element_sum() * reach + r[3].abs();
        16.0 * 0.5 * f32::EPSILON * self.inverse.map(magnitude).into_iter().fold(0.0, f32::max)
    }
}

fn row(r: [f32; 4]) -> Vec3 {
    Vec3::new(r[0], r[1], r[2])
}

fn rows_of(map: &DAffine3) -> [[f32; 4]; 3] {
    let linear: DMat3 = map.matrix3.transpose();
    let rows = [linear.x_axis, linear.y_axis, linear.z_axis];
    std::array::from_fn(|i| [rows[i].x as f32, rows[i].y as f32, rows[i].z as f32, map.translation[i] as f32])
}
