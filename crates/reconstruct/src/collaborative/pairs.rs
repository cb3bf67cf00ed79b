//! Distances between single pixels of a fixed offset, in both directions and for several pictures at once: what depends
//! on the variance alone is the same for all of them.

use pulp::Simd;

use super::fitted::Guides;
use super::region::Region;
use crate::eight::{Eight, LANES};
use crate::rectangle::Rectangle;

/// Distances of single pixels (eq. 10, summed over channels) for one offset, row by row of a rectangle.
#[derive(Debug, Default)]
pub struct PairImages {
    /// Values from one row to the next.
    pub pitch: usize,
    /// One image per direction, for each picture: from a pixel to the one the offset away, and back. Only the first where
    /// both are the same.
    images: Vec<[Vec<f32>; 2]>,
    both_ways: bool,
}

impl PairImages {
    /// For `guides`.
    pub fn new(guides: &Guides) -> Self {
        let images = guides.values.iter().map(|_| Default::default()).collect();
        Self { pitch: 0, images, both_ways: is_one_sided(guides) }
    }

    /// Distances of `picture` in `direction` (0 or 1).
    #[inline(always)]
    pub fn image(&self, picture: usize, direction: usize) -> &[f32] {
        &self.images[picture][if self.both_ways { direction } else { 0 }]
    }

    /// Compares the pixels of `valid` in those of its rows that are `needed`, with those `offset` away. `region` holds
    /// the variances of `guides`, then the values of each picture.
    #[inline(always)]
    pub fn compare<S: Simd>(
        &mut self,
        simd: S,
        guides: &Guides,
        region: &Region,
        valid: Rectangle,
        offset: [isize; 2],
        needed: impl Fn(usize) -> bool,
    ) {
        self.pitch = valid.width().next_multiple_of(LANES);
        let directions = if self.both_ways { 2 } else { 1 };
        for image in self.images.iter_mut().flat_map(|images| &mut images[..directions]) {
            image.resize(self.pitch * valid.height(), 0.0);
        }
        let step = offset[0] + offset[1] * region.width() as isize;
        for y in (valid.y0..valid.y1).filter(|y| needed(*y)) {
            let at = (y - valid.y0) * self.pitch;
            let pair = PairRow { guides, region, x: valid.x0, y, step };
            match &mut self.images[..] {
                [one] => pair.compare(simd, [one].map(|images| rows(images, at, self.pitch))),
                [one, two, ..] => pair.compare(simd, [one, two].map(|images| rows(images, at, self.pitch))),
                [] => {}
            }
        }
    }
}

/// Whether a distance depends on the direction: noise that is taken off is that of one end.
fn is_one_sided(guides: &Guides) -> bool {
    guides.comparison.noise_taken_off != 0.0
}

/// A row of both images; nothing of one that is not there.
fn rows(images: &mut [Vec<f32>; 2], at: usize, pitch: usize) -> [&mut [f32]; 2] {
    images.each_mut().map(|image| image.get_mut(at..at + pitch).unwrap_or_default())
}

/// One row of pairs.
struct PairRow<'a> {
    guides: &'a Guides<'a>,
    region: &'a Region,
    x: usize,
    y: usize,
    step: isize,
}

impl PairRow<'_> {
    /// Values of plane `number` at both ends of the pairs.
    #[inline(always)]
    fn ends(&self, number: usize, count: usize) -> [&[f32]; 2] {
        let here = self.region.index(number, self.x, self.y);
        [here, here.wrapping_add_signed(self.step)].map(|start| &self.region.from(start)[..count])
    }

    #[inline(always)]
    fn compare<S: Simd, const PICTURES: usize>(&self, simd: S, mut out: [[&mut [f32]; 2]; PICTURES]) {
        match self.guides.variances.len() {
            3 => self.channels::<S, PICTURES, 3>(simd, 0, &mut out, false),
            channels => (0..channels).for_each(|c| self.channels::<S, PICTURES, 1>(simd, c, &mut out, c > 0)),
        }
    }

    /// Adds the distances of `CHANNELS` channels from number `first` on, or begins with them.
    #[inline(always)]
    fn channels<S: Simd, const PICTURES: usize, const CHANNELS: usize>(
        &self,
        simd: S,
        first: usize,
        out: &mut [[&mut [f32]; 2]; PICTURES],
        add: bool,
    ) {
        let count = out[0][0].len();
        let all = self.guides.variances.len();
        let variances: [[&[f32]; 2]; CHANNELS] = std::array::from_fn(|c| self.ends(first + c, count));
        let values: [[[&[f32]; 2]; CHANNELS]; PICTURES] =
            std::array::from_fn(|p| std::array::from_fn(|c| self.ends((p + 1) * all + first + c, count)));
        let one = Eight::splat(simd, 1.0);
        let epsilon = Eight::splat(simd, self.guides.comparison.epsilon);
        let less_noise = Eight::splat(simd, -self.guides.comparison.noise_taken_off);
        let one_sided = is_one_sided(self.guides);
        for at in (0..count).step_by(LANES) {
            let mut noise = [Eight::splat(simd, 0.0); 2];
            let mut squares = [Eight::splat(simd, 0.0); PICTURES];
            for c in 0..CHANNELS {
                let here = Eight::load(simd, &variances[c][0][at..]);
                let there = Eight::load(simd, &variances[c][1][at..]);
                let scale = one.div(simd, epsilon.add(simd, here).add(simd, there));
                if one_sided {
                    let least = here.min(simd, there);
                    noise[0] = here.add(simd, least).mul_add(simd, scale, noise[0]);
                    noise[1] = there.add(simd, least).mul_add(simd, scale, noise[1]);
                }
                for (square, values) in squares.iter_mut().zip(&values) {
                    let here = Eight::load(simd, &values[c][0][at..]);
                    let difference = here.sub(simd, Eight::load(simd, &values[c][1][at..]));
                    *square = difference.mul(simd, difference).mul_add(simd, scale, *square);
                }
            }
            for (square, out) in squares.iter().zip(out.iter_mut()) {
                for (noise, out) in noise.iter().zip(out).take(if one_sided { 2 } else { 1 }) {
                    let to = &mut out[at..at + LANES];
                    let distance = noise.mul_add(simd, less_noise, *square);
                    let before = if add { Eight::load(simd, to) } else { Eight::splat(simd, 0.0) };
                    distance.add(simd, before).store(to);
                }
            }
        }
    }
}
