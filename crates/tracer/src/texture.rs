//! Images on surfaces.

use std::sync::OnceLock;

use glam::{Mat2, Vec2, Vec3};

/// A decoded image, looked up bilinearly with coordinates that repeat or stop at the border.
#[derive(Clone, Debug)]
pub struct Raster<T> {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row-major, top row first.
    pub texels: Vec<T>,
    /// What texture coordinates are multiplied with: how often the image repeats over one unit of them, and how it is turned.
    pub map: Mat2,
    /// Added to that.
    pub offset: Vec2,
    /// What lies outside of it, to the sides and above and below.
    pub wrap: [Wrap; 2],
    /// Which set of texture coordinates it is laid out by: 0, or 1 for the further one.
    pub set: u8,
    /// Of numbers, the least and the greatest; found out when first needed.
    pub(crate) range: OnceLock<[f32; 2]>,
}

/// Where a point lies on images: in the set of texture coordinates that most are laid out by, and in a further one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexCoords(pub [Vec2; 2]);

impl TexCoords {
    /// Where every set begins.
    pub const ZERO: Self = Self([Vec2::ZERO; 2]);

    /// The sum of those of three corners by their weights.
    pub(crate) fn weighted(weights: [f32; 3], corners: [Self; 3]) -> Self {
        let [a, b, c] = corners.map(|corner| corner.0);
        Self([0, 1].map(|set| weights[0] * a[set] + weights[1] * b[set] + weights[2] * c[set]))
    }
}

impl From<Vec2> for TexCoords {
    /// The same in both sets.
    fn from(uv: Vec2) -> Self {
        Self([uv; 2])
    }
}

/// What lies outside of an image, along one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// Its border, which goes on.
    Clamp,
    /// The image again, every other time turned round.
    Mirror,
}

/// A colour, linear RGB, or three numbers of another kind.
pub type Texture = Raster<[f32; 3]>;

/// One number a pixel.
pub type GreyTexture = Raster<f32>;

/// What an image may hold.
pub trait Texel: Copy {
    /// What a lookup returns.
    type Value: Copy;

    /// `self` as the lookup returns it.
    fn value(self) -> Self::Value;

    /// From `a` to `b` by the share `t`.
    fn between(a: Self::Value, b: Self::Value, t: f32) -> Self::Value;
}

impl Texel for [f32; 3] {
    type Value = Vec3;

    #[inline]
    fn value(self) -> Vec3 {
        Vec3::from_array(self)
    }

    #[inline]
    fn between(a: Vec3, b: Vec3, t: f32) -> Vec3 {
        a.lerp(b, t)
    }
}

impl Texel for f32 {
    type Value = f32;

    #[inline]
    fn value(self) -> f32 {
        self
    }

    #[inline]
    fn between(a: f32, b: f32, t: f32) -> f32 {
        a * (1.0 - t) + b * t
    }
}

impl<T: Texel> Raster<T> {
    /// A texture that covers texture coordinates 0 … 1 once, and repeats.
    ///
    /// # Panics
    /// When there are not `width` × `height` texels, or none: that is a mistake in the calling code.
    pub fn new(width: usize, height: usize, texels: Vec<T>) -> Self {
        assert!(!texels.is_empty() && texels.len() == width * height, "texels must fill the image");
        Self {
            width,
            height,
            texels,
            map: Mat2::IDENTITY,
            offset: Vec2::ZERO,
            wrap: [Wrap::Repeat; 2],
            set: 0,
            range: OnceLock::new(),
        }
    }

    /// What the image shows at texture coordinates `uv` (origin at the image's bottom left, as OBJ has it).
    ///
    /// Texel centres lie at half-integers. Coordinates that are not finite give the first texel.
    pub fn lookup(&self, uv: impl Into<TexCoords>) -> T::Value {
        let uv = self.map * uv.into().0[usize::from(self.set)] + self.offset;
        let [across, down] = self.wrap;
        let (x0, x1, fx) = neighbours(uv.x, self.width, across);
        let (y0, y1, fy) = neighbours(1.0 - uv.y, self.height, down);
        let texel = |x: usize, y: usize| self.texels[y * self.width + x].value();
        let top = T::between(texel(x0, y0), texel(x1, y0), fx);
        let bottom = T::between(texel(x0, y1), texel(x1, y1), fx);
        T::between(top, bottom, fy)
    }
}

impl GreyTexture {
    /// Its number, when it is the same everywhere.
    pub fn constant(&self) -> Option<f32> {
        let first = self.texels[0];
        self.texels.iter().all(|texel| *texel == first).then_some(first)
    }

    /// The least and the greatest of its numbers, but for those that are NaN.
    pub fn range(&self) -> [f32; 2] {
        *self.range.get_or_init(|| {
            let wider = |[least, greatest]: [f32; 2], texel: &f32| [least.min(*texel), greatest.max(*texel)];
            self.texels.iter().fold([f32::INFINITY, f32::NEG_INFINITY], wider)
        })
    }
}

impl Texture {
    /// Mean colour.
    pub fn mean(&self) -> Vec3 {
        let sum = self.texels.iter().fold(glam::DVec3::ZERO, |sum, &t| sum + Vec3::from_array(t).as_dvec3());
        (sum / self.texels.len() as f64).as_vec3()
    }
}

/// The two texels round coordinate `c` (1 is the whole image) in a row of `count`, and the weight of the second.
fn neighbours(c: f32, count: usize, wrap: Wrap) -> (usize, usize, f32) {
    let within = match wrap {
        Wrap::Repeat => c - c.floor(),
        Wrap::Clamp => c.clamp(0.0, 1.0),
        Wrap::Mirror => 1.0 - (c - 2.0 * (0.5 * c).floor() - 1.0).abs(),
    };
    let position = within * count as f32 - 0.5;
    if !position.is_finite() {
        return (0, 0, 0.0);
    }
    let below = position.floor();
    let place = |i: isize| {
        let last = count as isize - 1;
        // The fraction is below 1 but its product may round up to `count`.
        // A mirrored image goes on with its own border.
        (if wrap == Wrap::Repeat { i.rem_euclid(last + 1) } else { i.clamp(0, last) }) as usize
    };
    (place(below as isize), place(below as isize + 1), position - below)
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
        let t = Texture { map: Mat2::from_diagonal(Vec2::new(2.0, 1.0)), offset: Vec2::new(0.5, 0.5), ..checker() };
        assert_eq!(t.lookup(Vec2::new(0.375, 0.25)), checker().lookup(Vec2::new(0.25, 0.75)));
        assert_eq!(t.mean(), Vec3::splat(0.25));
    }

    #[test]
    fn an_image_is_looked_up_in_its_own_set_of_coordinates() {
        let both = TexCoords([Vec2::new(0.25, 0.75), Vec2::new(0.75, 0.25)]);
        assert_eq!(checker().lookup(both), Vec3::X);
        assert_eq!(Texture { set: 1, ..checker() }.lookup(both), Vec3::Z);
    }

    #[test]
    fn a_clamped_image_ends_at_its_border() {
        let t = Texture { wrap: [Wrap::Clamp; 2], ..checker() };
        for (outside, border) in [([-3.0, 0.75], [0.0, 0.75]), ([0.75, 9.0], [0.75, 1.0]), ([2.0, -2.0], [1.0, 0.0])] {
            assert_eq!(t.lookup(Vec2::from(outside)), t.lookup(Vec2::from(border)));
        }
        assert_eq!(t.lookup(Vec2::new(0.0, 1.0)), Vec3::X);
        assert_eq!(t.lookup(Vec2::new(0.5, 1.0)), 0.5 * Vec3::X);
    }

    #[test]
    fn every_other_mirrored_image_is_turned_round() {
        let t = Texture { wrap: [Wrap::Mirror, Wrap::Clamp], ..checker() };
        for (x, same) in [(1.2, 0.8), (-0.3, 0.3), (2.4, 0.4), (3.75, 0.25), (-1.6, 0.4)] {
            let [found, expected] = [x, same].map(|x| t.lookup(Vec2::new(x, 0.7)));
            assert!((found - expected).length() < 1e-5, "{x}: {found} {expected}");
        }
        assert_eq!(t.lookup(Vec2::new(0.0, 0.75)), Vec3::X, "nothing is blended across a border");
        assert_eq!(t.lookup(Vec2::new(0.25, 7.0)), Vec3::X);
    }

    #[test]
    fn grey_images_are_looked_up_alike() {
        let grey = GreyTexture::new(2, 2, vec![1.0, 0.0, 0.5, 0.25]);
        assert_eq!(grey.lookup(Vec2::new(0.25, 0.75)), 1.0);
        assert_eq!(grey.lookup(Vec2::new(0.5, 0.25)), 0.375);
        assert_eq!(grey.range(), [0.0, 1.0]);
    }

    #[test]
    fn coordinates_that_are_not_finite_or_just_below_a_whole_number_stay_inside() {
        let t = checker();
        for c in [f32::NAN, f32::INFINITY, -f32::MIN_POSITIVE, 1.0f32.next_down(), 1e30] {
            assert!(t.lookup(Vec2::new(c, c)).is_finite());
            for wrap in [Wrap::Clamp, Wrap::Mirror] {
                assert!(Texture { wrap: [wrap; 2], ..checker() }.lookup(Vec2::new(c, c)).is_finite());
            }
        }
    }
}
