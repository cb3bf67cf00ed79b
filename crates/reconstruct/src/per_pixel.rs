//! Planes that are filled pixel by pixel, on all threads.

use rayon::prelude::*;

/// Pixels that one task works on.
const CHUNK: usize = 4096;

/// The `N` planes of as many `pixels` whose numbers are `values` of each pixel.
pub fn planes<const N: usize>(pixels: usize, values: impl Fn(usize) -> [f32; N] + Sync) -> [Vec<f32>; N] {
    let mut planes: [Vec<f32>; N] = std::array::from_fn(|_| vec![0.0; pixels]);
    let mut chunks = planes.each_mut().map(|plane| plane.chunks_mut(CHUNK));
    let parts: Vec<[&mut [f32]; N]> = (0..pixels.div_ceil(CHUNK))
        .map(|_| chunks.each_mut().map(|chunks| chunks.next().unwrap_or_default()))
        .collect();
    parts.into_par_iter().enumerate().for_each(|(number, mut part)| {
        for i in 0..part.first().map_or(0, |plane| plane.len()) {
            for (plane, value) in part.iter_mut().zip(values(number * CHUNK + i)) {
                plane[i] = value;
            }
        }
    });
    planes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_filled_once() {
        for pixels in [0, 1, CHUNK, 2 * CHUNK + 5] {
            let [a, b] = planes(pixels, |pixel| [pixel as f32, 0.5 - pixel as f32]);
            assert!(a.len() == pixels && b.len() == pixels);
            assert!((0..pixels).all(|pixel| a[pixel] == pixel as f32 && b[pixel] == 0.5 - pixel as f32));
        }
    }
}
