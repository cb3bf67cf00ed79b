//! Positions and normals in camera space (pbrt's default) taken to world space.

use crate::Image;

/// Share of visible normals that must face the camera for a space to be the right one.
const FACING: f64 = 0.97;

/// By how much the other space must be less right.
const CLEARER: f64 = 0.05;

/// Rotation and translation: p_camera = R p_world + t.
#[derive(Clone, Copy, Debug)]
struct Rigid {
    rotation: [[f32; 3]; 3],
    translation: [f32; 3],
}

/// An image of vectors that turn with the camera.
pub enum Oriented<'a> {
    /// Places.
    Position(&'a mut Image),
    /// Directions.
    Normal(&'a mut Image),
}

/// Takes `images` from camera to world space, where the file's matrix (`worldToCamera`) allows it and `position` and
/// `normal` say that camera space is what they are in: there visible surfaces face the origin, in world space the eye.
/// Says whether it did. A matrix without a translation leaves open which of its two transposes is meant, and is not used.
pub fn to_world_space(matrix: &[f32; 16], position: &Image, normal: &Image, images: &mut [Oriented<'_>]) -> bool {
    // Of the pixels, before any of them is changed.
    let Some(camera) = rigid(matrix) else { return false };
    let eye = camera.to_world_point([0.0; 3]);
    let (in_camera, in_world) = (facing(position, normal, [0.0; 3]), facing(position, normal, eye));
    if in_camera < FACING || in_camera < in_world + CLEARER {
        return false;
    }
    for image in images {
        match image {
            Oriented::Position(image) => turn(image, |v| camera.to_world_point(v)),
            Oriented::Normal(image) => turn(image, |v| camera.to_world_direction(v)),
        }
    }
    true
}

impl Rigid {
    fn to_world_direction(self, v: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|column| (0..3).map(|row| self.rotation[row][column] * v[row]).sum())
    }

    fn to_world_point(self, p: [f32; 3]) -> [f32; 3] {
        self.to_world_direction([0, 1, 2].map(|c| p[c] - self.translation[c]))
    }
}

/// The matrix, whichever way it is written: for row vectors (OpenEXR) or for columns.
fn rigid(m: &[f32; 16]) -> Option<Rigid> {
    let (last_row, last_column) = ([m[12], m[13], m[14]], [m[3], m[7], m[11]]);
    let is_zero = |v: [f32; 3]| v.iter().all(|x| *x == 0.0);
    let at = |row: usize, column: usize| m[4 * row + column];
    let rigid = match (is_zero(last_row), is_zero(last_column)) {
        (true, false) => Rigid { rotation: square(at), translation: last_column },
        (false, true) => Rigid { rotation: square(|row, column| at(column, row)), translation: last_row },
        _ => return None,
    };
    let dot = |a: usize, b: usize| (0..3).map(|i| rigid.rotation[a][i] * rigid.rotation[b][i]).sum::<f32>();
    let is_rotation = (0..3).all(|a| (0..3).all(|b| (dot(a, b) - f32::from(u8::from(a == b))).abs() < 1e-3));
    (is_rotation && m[15] == 1.0).then_some(rigid)
}

fn square(at: impl Fn(usize, usize) -> f32) -> [[f32; 3]; 3] {
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| at(row, column)))
}

/// Share of the normals that face `eye`.
fn facing(position: &Image, normal: &Image, eye: [f32; 3]) -> f64 {
    let (mut all, mut toward) = (0_u64, 0_u64);
    for pixel in 0..position.pixels() {
        let (p, n) = (position.rgb(pixel), normal.rgb(pixel));
        let dot: f32 = (0..3).map(|c| n[c] * (p[c] - eye[c])).sum();
        if n != [0.0; 3] && dot.is_finite() {
            all += 1;
            toward += u64::from(dot < 0.0);
        }
    }
    if all == 0 { 0.0 } else { toward as f64 / all as f64 }
}

fn turn(image: &mut Image, f: impl Fn([f32; 3]) -> [f32; 3]) {
    for pixel in 0..image.pixels() {
        let turned = f(image.rgb(pixel));
        image.channels_mut().iter_mut().zip(turned).for_each(|(plane, v)| plane[pixel] = v);
    }
}
