//! Planes that are filled pixel by pixel, on all threads.

use rayon::prelude::*;
use stack::Size;

use crate::eight::{LANES, Lanes};

/// Pixels that one task works on.
const CHUNK: usize = 4096;

/// The plane of as many `pixels` whose values are those of each pixel.
pub fn plane(pixels: usize, value: impl Fn(usize) -> f32 + Sync) -> Vec<f32> {
    let [plane] = planes(pixels, |pixel| [value(pixel)]);
    plane
}

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

/// What fills `N` planes eight pixels at a time. Not a closure: those are not inlined into code for the widest instructions
/// there are.
pub trait ByEight<const N: usize>: Sync {
    /// The numbers of some pixels; to be marked `#[inline(always)]`.
    fn numbers(&self, pixels: Pixels) -> [Lanes; N];
}

/// The same by `values` of eight pixels at once.
pub fn planes_by_eight<const N: usize>(pixels: usize, values: &impl ByEight<N>) -> [Vec<f32>; N] {
    filled(pixels, |first, part: &mut [&mut [f32]; N]| {
        pulp::Arch::new().dispatch(PartTask { pixels, first, part, values });
    })
}

/// Eight consecutive pixels, or all there are.
#[derive(Clone, Copy, Debug)]
pub struct Pixels {
    first: usize,
    count: usize,
}

impl Pixels {
    /// Their numbers in `plane`; zeros stand for pixels that there are not.
    #[inline(always)]
    pub fn of(self, plane: &[f32]) -> Lanes {
        // An array of known length, or this becomes a call.
        if let Some(eight) = plane[self.first..].first_chunk() {
            return *eight;
        }
        let mut values = [0.0; LANES];
        values[..plane.len()].copy_from_slice(plane);
        values
    }

    /// The numbers in `plane`, of `size`, of the pixels so many columns and rows away. Where [`Self::inside`] is 0 they are
    /// some others' or zeros.
    #[inline(always)]
    pub fn moved(self, plane: &[f32], size: Size, [dx, dy]: [isize; 2]) -> Lanes {
        let by = dy * size.width as isize + dx;
        let first = self.first.checked_add_signed(by);
        if let Some(eight) = first.and_then(|first| plane.get(first..)).and_then(|rest| rest.first_chunk()) {
            return *eight;
        }
        let mut values = [0.0; LANES];
        for (i, value) in values.iter_mut().enumerate() {
            let pixel = (self.first + i).checked_add_signed(by);
            *value = pixel.and_then(|pixel| plane.get(pixel)).copied().unwrap_or_default();
        }
        values
    }

    /// 1 for each of them that is inside a picture of `size` when moved by so many columns and rows, 0 for the others.
    #[inline(always)]
    pub fn inside(self, size: Size, [dx, dy]: [isize; 2]) -> Lanes {
        let is_inside = |at: usize, by, length| at.checked_add_signed(by).is_some_and(|at| at < length);
        let (mut x, mut y) = (self.first % size.width, self.first / size.width);
        let mut inside = [0.0; LANES];
        for inside in &mut inside[..self.count] {
            *inside = f32::from(u8::from(is_inside(x, dx, size.width) && is_inside(y, dy, size.height)));
            x += 1;
            if x == size.width {
                (x, y) = (0, y + 1);
            }
        }
        inside
    }

    /// What `value` is of each of them; zeros stand for pixels that there are not.
    #[inline(always)]
    pub fn map(self, value: impl Fn(usize) -> f32) -> Lanes {
        let mut values = [0.0; LANES];
        for i in 0..self.count {
            values[i] = value(self.first + i);
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

struct PartTask<'a, 'p, V, const N: usize> {
    /// Of the whole picture.
    pixels: usize,
    first: usize,
    part: &'a mut [&'p mut [f32]; N],
    values: &'a V,
}

impl<V: ByEight<N>, const N: usize> pulp::NullaryFnOnce for PartTask<'_, '_, V, N> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let length = self.part.first().map_or(0, |plane| plane.len());
        for at in (0..length).step_by(LANES) {
            // At the end of a picture, some pixels once more.
            let first = (self.first + at).min(self.pixels.saturating_sub(LANES));
            let pixels = Pixels { first, count: LANES.min(self.pixels) };
            let (known, values) = (self.first + at - first, self.values.numbers(pixels));
            for (plane, values) in self.part.iter_mut().zip(&values) {
                match plane[at..].first_chunk_mut() {
                    Some(eight) if known == 0 => *eight = *values,
                    _ => plane[at..].iter_mut().zip(&values[known..]).for_each(|(to, value)| *to = *value),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Swapped<'a>([&'a [f32]; 2]);

    impl ByEight<2> for Swapped<'_> {
        fn numbers(&self, pixels: Pixels) -> [Lanes; 2] {
            [pixels.of(self.0[1]), pixels.map(|pixel| self.0[0][pixel])]
        }
    }

    #[test]
    fn every_pixel_is_filled_once() {
        for pixels in [0, 1, 13, CHUNK, 2 * CHUNK + 5] {
            let [a, b] = planes(pixels, |pixel| [pixel as f32, 0.5 - pixel as f32]);
            assert!(a.len() == pixels && b.len() == pixels);
            assert!((0..pixels).all(|pixel| a[pixel] == pixel as f32 && b[pixel] == 0.5 - pixel as f32));
            let [c, d] = planes_by_eight(pixels, &Swapped([&a, &b]));
            assert!(c == b && d == a);
        }
    }

    struct Moved<'a>(Size, [isize; 2], &'a [f32]);

    impl ByEight<2> for Moved<'_> {
        fn numbers(&self, pixels: Pixels) -> [Lanes; 2] {
            let Self(size, by, plane) = self;
            [pixels.moved(plane, *size, *by), pixels.inside(*size, *by)]
        }
    }

    #[test]
    fn neighbours_are_found_and_the_border_is_known() {
        for size in [Size::new(11, 5), Size::new(3, 1), Size::new(1, 9)] {
            let numbers: Vec<f32> = (1..=size.pixels()).map(|i| i as f32).collect();
            for by in [[0, 0], [2, -1], [-3, 1], [1, 4], [-20, 0]] {
                let [moved, inside] = planes_by_eight(size.pixels(), &Moved(size, by, &numbers));
                for pixel in 0..size.pixels() {
                    let [x, y] = [(pixel % size.width) as isize + by[0], (pixel / size.width) as isize + by[1]];
                    let there = (0..size.width as isize).contains(&x) && (0..size.height as isize).contains(&y);
                    assert_eq!(inside[pixel], f32::from(u8::from(there)), "{size:?} {by:?} {pixel}");
                    if there {
                        assert_eq!(moved[pixel], numbers[size.index(x as usize, y as usize)]);
                    }
                }
            }
        }
    }
}
