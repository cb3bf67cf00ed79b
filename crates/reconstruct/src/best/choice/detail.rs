//! How much detail there is around a pixel.

use rayon::prelude::*;
use stack::{Image, Size};

use super::Contest;
use crate::box_filter::box_mean;
use crate::ln::ln;
use crate::per_pixel::plane;

/// Planes of detail.
pub const DETAILS: usize = 4;
/// Radii of the boxes that detail is averaged over, in pixels.
const RADII: [usize; 2] = [1, 4];
/// Detail below this is all the same.
const LEAST: f32 = 0.01;

/// Logarithms of the mean step between neighbours: of the logarithm of the pilot's brightness around a pixel and farther
/// around it, then of the features that tell surfaces apart.
pub fn details(contest: &Contest) -> [Vec<f32>; DETAILS] {
    let size = contest.pilot.size();
    let surfaces: Vec<&[f32]> = contest.features.separators().collect();
    let (bright, surface) = (steps(&[logarithm(contest.pilot)], size), steps(&surfaces, size));
    let around = |steps: &[f32], radius: usize| {
        let mean = box_mean(steps, size, radius);
        plane(mean.len(), |pixel| ln(mean[pixel] + LEAST))
    };
    let [near, far] = RADII;
    [around(&bright, near), around(&bright, far), around(&surface, near), around(&surface, far)]
}

fn logarithm(picture: &Image) -> Vec<f32> {
    plane(picture.pixels(), |pixel| ln(picture.mean_at(pixel).max(0.0) + 0.02))
}

/// Σ over `planes` of how far a pixel is from those left of and above it.
fn steps(planes: &[impl AsRef<[f32]>], size: Size) -> Vec<f32> {
    let planes: Vec<&[f32]> = planes.iter().map(AsRef::as_ref).collect();
    let mut sums = vec![0.0; size.pixels()];
    sums.par_chunks_mut(size.width.max(1)).enumerate().for_each(|(y, sums)| {
        let row = y * size.width..(y + 1) * size.width;
        for plane in &planes {
            let above = &plane[row.start.saturating_sub(size.width)..][..size.width];
            let mut left = plane[row.start];
            for ((sum, value), above) in sums.iter_mut().zip(&plane[row.clone()]).zip(above) {
                *sum += (value - left).abs() + (value - above).abs();
                left = *value;
            }
        }
    });
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_those_to_the_left_and_up() {
        let planes = [[1.0, 3.0, 0.0, 10.0], [0.0, 0.0, 0.5, 0.5]];
        assert_eq!(steps(&planes, Size::new(2, 2)), [0.0, 2.0, 1.5, 17.5]);
    }
}
