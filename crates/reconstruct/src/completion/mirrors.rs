//! Surfaces whose albedo says nothing of what is seen there: mirrors, glass and polished metal.

use stack::{Image, Size};

use crate::marks::grown;

/// Renderers write no albedo at all for what only mirrors or refracts; none has less than this.
const BLACK: f32 = 0.01;

/// Or they write a perfect white, or what becomes it: the quotient of radiance and density is far above 1 on polished metal.
const WHITE: f32 = 0.999;

/// Gaps between such pixels belong to them, up to twice this share of the picture's shorter side: that quotient falls from far
/// above 1 to 0 across a ball.
const GAP: f32 = 1.0 / 64.0;

/// Pixels with a surface whose albedo is black or white, and the gaps between them. Where the sky is seen there is no normal.
pub fn surfaces_without_texture(albedo: &Image, normal: &Image) -> Vec<bool> {
    let size = albedo.size();
    let without = |pixel: usize| {
        let most = albedo.rgb(pixel).into_iter().fold(0.0, f32::max);
        let length = normal.rgb(pixel).iter().map(|v| v * v).sum::<f32>();
        (most <= BLACK || most >= WHITE) && length > 0.01
    };
    let marks: Vec<bool> = (0..size.pixels()).map(without).collect();
    closed(&marks, size, (GAP * size.width.min(size.height) as f32) as usize)
}

/// `marks` with what lies between them, up to twice `radius` wide.
fn closed(marks: &[bool], size: Size, radius: usize) -> Vec<bool> {
    let outside: Vec<bool> = grown(marks, size, radius).into_iter().map(|mark| !mark).collect();
    grown(&outside, size, radius).into_iter().map(|mark| !mark).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Marks of pixels in a row that is far higher than any gap is wide, their albedo and whether there is a surface.
    fn marks(albedo: &[f32], surface: &[bool]) -> Vec<bool> {
        let size = Size::new(albedo.len(), 128);
        let rows = |of: &dyn Fn(usize) -> f32| (0..size.pixels()).map(|i| of(i % albedo.len())).collect::<Vec<f32>>();
        let grey = Image::from_channels(size, (0..3).map(|_| rows(&|x| albedo[x])).collect());
        let up = rows(&|x| f32::from(u8::from(surface[x])));
        let zeros = vec![0.0; size.pixels()];
        let normal = Image::from_channels(size, vec![zeros.clone(), up, zeros]);
        surfaces_without_texture(&grey, &normal)[..albedo.len()].to_vec()
    }

    fn at(places: impl IntoIterator<Item = usize>) -> Vec<bool> {
        let mut marks = vec![false; 128];
        places.into_iter().for_each(|x| marks[x] = true);
        marks
    }

    #[test]
    fn black_and_white_are_marked_and_small_gaps_between_them() {
        let mut albedo = [0.5; 128];
        albedo[20..24].fill(0.0);
        albedo[28..30].fill(1.0);
        assert_eq!(marks(&albedo, &[true; 128]), at(20..30));
        albedo[27..29].fill(0.5);
        assert_eq!(marks(&albedo, &[true; 128]), at((20..24).chain(29..30)), "a gap of five");
    }

    #[test]
    fn the_sky_and_what_is_seen_before_it_are_not() {
        let (mut albedo, mut surface) = ([0.5; 128], [true; 128]);
        albedo[40..50].fill(0.0);
        surface[40..50].fill(false);
        albedo[52] = 0.0;
        assert_eq!(marks(&albedo, &surface), at([52]));
    }
}
