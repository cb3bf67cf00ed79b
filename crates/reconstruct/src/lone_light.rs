//! Pixels that stick out of their neighbours, in a picture that has no buckets to tell a firefly by.

use stack::{Image, Size};

use crate::collaborative::offsets;
use crate::eight::{LANES, Lanes};
use crate::per_pixel::{ByEight, Pixels, plane, planes_by_eight};

/// A pixel is cut where it exceeds this multiple of what its neighbours reach: the second largest of 24 …
const FACTOR: f32 = 2.0;

/// … within this many pixels.
const RADIUS: usize = 2;

/// Least luminance that anything is cut at.
const LEAST_CAP: f32 = 1e-4;

/// Share of every pixel's light in `image` that its neighbours account for: 1, or less where it alone is bright.
pub fn share_like_neighbours(image: &Image) -> Vec<f32> {
    let size = image.size();
    let luminance = plane(size.pixels(), |pixel| image.mean_at(pixel).max(0.0));
    let [shares] = planes_by_eight(size.pixels(), &Shares { luminance: &luminance, size });
    shares
}

struct Shares<'a> {
    luminance: &'a [f32],
    size: Size,
}

impl ByEight<1> for Shares<'_> {
    #[inline(always)]
    fn numbers(&self, pixels: Pixels) -> [Lanes; 1] {
        let (mut largest, mut second) = ([f32::NEG_INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
        for offset in offsets(RADIUS) {
            if offset == [0, 0] {
                continue;
            }
            let near = pixels.moved(self.luminance, self.size, offset);
            let inside = pixels.inside(self.size, offset);
            for lane in 0..LANES {
                let near = if inside[lane] > 0.0 { near[lane] } else { f32::NEG_INFINITY };
                second[lane] = second[lane].max(near.min(largest[lane]));
                largest[lane] = largest[lane].max(near);
            }
        }
        let own = pixels.of(self.luminance);
        let mut shares = [0.0; LANES];
        for lane in 0..LANES {
            // A pixel has no neighbour, one, or more.
            let reached = if second[lane] >= 0.0 { second[lane] } else { largest[lane] };
            let cap = if reached >= 0.0 { (FACTOR * reached).max(LEAST_CAP) } else { f32::INFINITY };
            shares[lane] = (cap / own[lane].max(1e-9)).min(1.0);
        }
        [shares]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size::new(20, 16);

    fn shares(value: impl Fn(usize, usize) -> f32) -> Vec<f32> {
        let plane: Vec<f32> = (0..SIZE.pixels()).map(|i| value(i % SIZE.width, i / SIZE.width)).collect();
        share_like_neighbours(&Image::from_channels(SIZE, vec![plane; 3]))
    }

    #[test]
    fn lone_pixels_are_cut_to_twice_their_neighbours() {
        let kept = shares(|x, y| if [x, y] == [9, 8] || [x, y] == [0, 0] { 50.0 } else { 1.0 });
        for (i, kept) in kept.into_iter().enumerate() {
            assert_eq!(kept, if i == 0 || i == SIZE.index(9, 8) { 2.0 / 50.0 } else { 1.0 }, "{i}");
        }
    }

    #[test]
    fn bright_areas_and_thin_lines_are_not_cut() {
        assert!(shares(|x, _| if x > 10 { 90.0 } else { 0.1 }).iter().all(|kept| *kept == 1.0));
        assert!(shares(|x, y| if x == 7 || y == 3 { 90.0 } else { 0.1 }).iter().all(|kept| *kept == 1.0));
    }

    #[test]
    fn a_pixel_by_itself_is_whole() {
        assert_eq!(share_like_neighbours(&Image::from_channels(Size::new(1, 1), vec![vec![3.0]; 3])), [1.0]);
    }
}
