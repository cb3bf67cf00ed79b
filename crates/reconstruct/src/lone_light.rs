//! Pixels that stick out of their neighbours, in a picture that has no buckets to tell a firefly by.

use rayon::prelude::*;
use stack::{Image, Size};

/// A pixel is cut where it exceeds this multiple of what its neighbours reach …
const FACTOR: f32 = 2.0;

/// … which is this quantile of them, the second largest of 24 …
const QUANTILE: f32 = 0.97;

/// … within this many pixels.
const RADIUS: usize = 2;

/// Least luminance that anything is cut at.
const LEAST_CAP: f32 = 1e-4;

/// Share of every pixel's light in `image` that its neighbours account for: 1, or less where it alone is bright.
pub fn share_like_neighbours(image: &Image) -> Vec<f32> {
    let size = image.size();
    let luminance: Vec<f32> = (0..size.pixels()).map(|pixel| image.mean_at(pixel).max(0.0)).collect();
    (0..size.pixels())
        .into_par_iter()
        .map(|pixel| (cap(&luminance, size, pixel) / luminance[pixel].max(1e-9)).min(1.0))
        .collect()
}

/// Luminance above which a pixel is cut.
fn cap(luminance: &[f32], size: Size, pixel: usize) -> f32 {
    let (x, y) = (pixel % size.width, pixel / size.width);
    let mut around = Vec::with_capacity((2 * RADIUS + 1).pow(2));
    for row in y.saturating_sub(RADIUS)..(y + RADIUS + 1).min(size.height) {
        for column in x.saturating_sub(RADIUS)..(x + RADIUS + 1).min(size.width) {
            if [column, row] != [x, y] {
                around.push(luminance[size.index(column, row)]);
            }
        }
    }
    if around.is_empty() {
        return f32::INFINITY;
    }
    let rank = ((around.len() - 1) as f32 * QUANTILE) as usize;
    let (_, reached, _) = around.select_nth_unstable_by(rank, f32::total_cmp);
    (FACTOR * *reached).max(LEAST_CAP)
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
