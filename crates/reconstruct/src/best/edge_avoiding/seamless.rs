//! Taps that fade towards the ends of surfaces.
//!
//! A kernel with gaps gains a tap all at once where that tap enters a surface: as many pixels as taps are apart beside each
//! edge, and beside the picture's border, there would be a seam. So two pixels weigh the less for each other the less equal
//! their masses are. The mass is the share of a pixel's surroundings, as wide as all finer kernels one after the other, that
//! lies on its surface: 1 inside of it, about 1/2 at a straight edge, where taps enter. Along an edge and on what is narrow,
//! masses are equal and nothing fades.

use pulp::NullaryFnOnce;
use stack::Size;

use super::taps::{MIDDLE, Taps, columns_with, for_each_row};
use crate::box_filter::box_mean;

/// Pixels weigh nothing for each other where one has this share of the other's mass, or less.
const LEAST_RATIO: f32 = 0.6;

/// A kernel's taps, ever wider, without seams.
pub struct Seamless<F> {
    taps_of: F,
    /// What the kernels so far leave of a plane of ones; empty before the first.
    mass: Vec<f32>,
}

impl<F: FnMut(usize) -> Taps> Seamless<F> {
    /// `taps_of` are those of the kernel, so many pixels apart.
    pub fn new(taps_of: F) -> Self {
        Self { taps_of, mass: Vec::new() }
    }

    /// Taps `step` pixels apart, twice as far as those asked for before.
    pub fn taps(&mut self, step: usize) -> Taps {
        let mut taps = (self.taps_of)(step);
        if self.mass.is_empty() {
            self.mass = taps.sum(&vec![1.0; taps.size.pixels()]);
            return taps;
        }
        let mass = taps.sum(&self.mass);
        // Gaps leave steps in the mass, too.
        taps.fade(&box_mean(&std::mem::replace(&mut self.mass, mass), taps.size, step / 4));
        taps
    }
}

impl Taps {
    /// Makes pixels weigh the less for each other the less equal their `mass` is.
    fn fade(&mut self, mass: &[f32]) {
        let (size, step) = (self.size, self.step);
        for_each_row(&mut self.weights, size.width, |y, weights| {
            pulp::Arch::new().dispatch(RowTask { size, step, mass, y, weights });
        });
    }
}

/// One row of a picture.
struct RowTask<'a> {
    size: Size,
    step: usize,
    mass: &'a [f32],
    y: usize,
    /// The row, once for each tap behind the middle.
    weights: Vec<&'a mut [f32]>,
}

impl NullaryFnOnce for RowTask<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { size, step, mass, y, weights } = self;
        for (behind, weights) in weights.into_iter().enumerate() {
            let columns = columns_with(MIDDLE + 1 + behind, size, step, y, 0..size.width);
            let Some((inside, there)) = columns else { continue };
            let here = &mass[size.index(inside.start, y)..][..inside.len()];
            let there = &mass[there..][..inside.len()];
            for (weight, (here, there)) in weights[inside].iter_mut().zip(here.iter().zip(there)) {
                let ratio = here.min(*there) / here.max(*there);
                *weight *= ((ratio - LEAST_RATIO) / (1.0 - LEAST_RATIO)).max(0.0);
            }
        }
    }
}
