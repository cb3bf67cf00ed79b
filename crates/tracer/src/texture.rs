//! Images on surfaces.

use glam::{Vec2, Vec3};

/// A decoded image, linear RGB, looked up bilinearly with coordinates that repeat.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row-major, top row first, linear RGB.
    pub texels: Vec<[f32; 3]>,
}

impl Texture {
    /// Colour at texture coordinates `uv` (origin at the image's bottom left, as OBJ has it).
    pub fn lookup(&self, uv: Vec2) -> Vec3 {
        let _ = uv;
        todo!("scene helper")
    }
}
