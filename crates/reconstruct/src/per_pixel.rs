//! Planes that are filled pixel by pixel, on all threads.

use rayon::prelude::*;

use crate::eight::LANES;

/// Pixels that one task works on.
const CHUNK: usize = 4096;

/// The `N` planes of as many `pixels` whose numbers are `values` of each pixel.
pub fn planes<const N: usize>(pixels: usize, values: impl Fn(usize) -> [f32; N] + Sync) -> [Vec<f32>; N] {
    filled(pixels, |first, part: &mut [&mut [f32]; N]| {
        for i in 0..part.first().map_or(0, |plane| plane.len()) {
            for (plane, value) in part.iter_mut().zip(values(first + i)) {
                plane[i] = value;
            }
        }
    })
}

/// The same where `values` knows the numbers of eight pixels at once, with the widest instructions there are.
pub fn planes_by_eight<const N: usize>(
    pixels: usize,
    values: impl Fn(Pixels) -> [[f32; LANES]; N] + Sync,
) -> [Vec<f32>; N] {
    filled(pixels, |first, part: &mut [&mut [f32]; N]| {
        pulp::Arch::new().dispatch(PartTask { first, part, values: &values })
    })
}

/// Consecutive pixels, eight of them or, at the end of a picture, fewer.
#[derive(Clone, Copy, Debug)]
pub struct Pixels {
    first: usize,
    count: usize,
}

impl Pixels {
    /// Their numbers in `plane`; zeros stand for pixels that there are not.
    #[inline(always)]
    pub fn of(self, plane: &[f32]) -> [f32; LANES] {
        let Self { first, count } = self;
        let mut values = [0.0; LANES];
        if count == LANES {
            values.copy_from_slice(&plane[first..first + LANES]);
        } else {
            values[..count].copy_from_slice(&plane[first..first + count]);
        }
        values
    }
}

/// Planes that `fill` fills part by part, from the number of a part's first pixel.
fn filled<const N: usize>(pixels: usize, fill: impl Fn(usize, &mut [&mut [f32]; N]) + Sync) -> [Vec<f32>; N] {
    let mut planes: [Vec<f32>; N] = std::array::from_fn(|_| vec![0.0; pixels]);
    let mut chunks = planes.each_mut().map(|plane| plane.chunks_mut(CHUNK));
    let parts: Vec<[&mut [f32]; N]> = (0..pixels.div_ceil(CHUNK))
        .map(|_| chunks.each_mut().map(|chunks| chunks.next().unwrap_or_default()))
        .collect();
    parts.into_par_iter().enumerate().for_each(|(number, mut part)| fill(number * CHUNK, &mut part));
    planes
}

struct PartTask<'a, 'p, F, const N: usize> {
    first: usize,
    part: &'a mut [&'p mut [f32]; N],
    values: &'a F,
}

impl<F: Fn(Pixels) -> [[f32; LANES]; N], const N: usize> pulp::NullaryFnOnce for PartTask<'_, '_, F, N> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let length = self.part.first().map_or(0, |plane| plane.len());
        for at in (0..length).step_by(LANES) {
            let count = LANES.min(length - at);
            let values = (self.values)(Pixels { first: self.first + at, count });
            for (plane, values) in self.part.iter_mut().zip(values) {
                plane[at..at + count].copy_from_slice(&values[..count]);
            }
        }
    }
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
            let [c, d] = planes_by_eight(pixels, |eight| [eight.of(&b), eight.of(&a)]);
            assert!(c == b && d == a);
        }
    }
}
