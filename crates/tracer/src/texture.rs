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
    /// How often the image repeats over one unit of the texture coordinates.
    pub scale: Vec2,
    /// Added to the scaled texture coordinates.
    pub offset: Vec2,
}

impl Texture {
    /// A texture that covers texture coordinates 0 … 1 once.
    ///
    /// # Panics
    /// When there are not `width` × `height` texels, or none: that is a mistake in the calling code.
    pub fn new(width: usize, height: usize, texels: Vec<[f32; 3]>) -> Self {
        assert!(!texels.is_empty() && texels.len() == width * height, "texels must fill the image");
        Self { width, height, texels, scale: Vec2::ONE, offset: Vec2::ZERO }
    }

    /// Mean colour.
    pub fn mean(&self) -> Vec3 {
        let sum = self.texels.iter().fold(glam::DVec3::ZERO, |sum, &t| sum + Vec3::from_array(t).as_dvec3());
        (sum / self.texels.len() as f64).as_vec3()
    }

    /// Colour at texture coordinates `uv` (origin at the image's bottom left, as OBJ has it).
    ///
    /// Texel centres lie at half-integers. Coordinates that are not finite give the first texel.
    pub fn lookup(&self, uv: Vec2) -> Vec3 {
        let uv = self.scale * uv + self.offset;
        let (x0, x1, fx) = neighbours(uv.x, self.width);
        let (y0, y1, fy) = neighbours(1.0 - uv.y, self.height);
        let texel = |x: usize, y: usize| Vec3::from_array(self.texels[y * self.width + x]);
        let top = texel(x0, y0).lerp(texel(x1, y0), fx);
        let bottom = texel(x0, y1).lerp(texel(x1, y1), fx);
        top.lerp(bottom, fy)
    }
}

/// The two texels round coordinate `c` (1 is the whole image) in a row of `count`, and the weight of the second.
fn neighbours(c: f32, count: usize) -> (usize, usize, f32) {
    let position = (c - c.floor()) * count as f32 - 0.5;
    if !position.is_finite() {
        return (0, 0, 0.0);
    }
    let below = position.floor();
    // The fraction is below 1 but its product may round up to `count`.
    let first = (below as isize).rem_euclid(count as isize) as usize;
    (first, (first + 1) % count, position - below)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checker() -> Texture {
        Texture::new(2, 2, vec![[1.0, 0.0, 0.0], [0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    }

    #[test]
    fn texel_centres_give_texels_with_the_first_row_on_top() {
        let t = checker();
        assert_eq!(t.lookup(Vec2::new(0.25, 0.75)), Vec3::X);
        assert_eq!(t.lookup(Vec2::new(0.25, 0.25)), Vec3::Y);
        assert_eq!(t.lookup(Vec2::new(0.75, 0.25)), Vec3::Z);
    }

    #[test]
    fn the_image_repeats_and_blends_across_its_border() {
        let t = checker();
        assert_eq!(t.lookup(Vec2::new(-2.75, 5.75)), t.lookup(Vec2::new(0.25, 0.75)));
        assert_eq!(t.lookup(Vec2::new(0.0, 0.75)), Vec3::new(0.5, 0.0, 0.0));
        assert_eq!(t.lookup(Vec2::new(0.0, 0.0)), Vec3::new(0.25, 0.25, 0.25));
    }

    #[test]
    fn the_image_can_be_scaled_and_shifted() {
        let t = Texture { scale: Vec2::new(2.0, 1.0), offset: Vec2::new(0.5, 0.5), ..checker() };
        assert_eq!(t.lookup(Vec2::new(0.375, 0.25)), checker().lookup(Vec2::new(0.25, 0.75)));
        assert_eq!(t.mean(), Vec3::splat(0.25));
    }

    #[test]
    fn coordinates_that_are_not_finite_or_just_below_a_whole_number_stay_inside() {
        let t = checker();
        for c in [f32::NAN, f32::INFINITY, -f32::MIN_POSITIVE, 1.0f32.next_down(), 1e30] {
            assert!(t.lookup(Vec2::new(c, c)).is_finite());
        }
    }
}
