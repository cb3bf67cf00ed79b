//! Weights of the cross-bilateral filter (the paper's equation 4, after its section 4).

use std::ops::Range;

use super::primary::{FEATURES, Primary};
use crate::exp::exp_of_negative;

/// Terms of a weight's exponent: distance on the screen, colour, and a term for each kind of feature.
pub const TERMS: usize = 2 + FEATURES;
/// Which term is the distance on the screen.
pub(super) const SPACE: usize = 0;
/// Which term is that of colours.
pub(super) const COLOUR: usize = 1;
/// Bandwidth 1 of the distance on the screen is this many pixels.
const SPACE_UNIT: f32 = 4.0;

/// One bandwidth per term, above 0: a weight is exp(−Σ Δ/(2γ²)) with the term's squared distance Δ.
pub type Bandwidths = [f32; TERMS];

/// Weights and distances of one row of pixels to those at one offset from them; keeps its buffers between rows.
#[derive(Clone, Debug, Default)]
pub(super) struct RowKernel {
    /// Columns whose neighbour lies inside.
    pub(super) columns: Range<usize>,
    /// Squared distance Δ of each term, a value per column of `columns`.
    pub(super) distances: [Vec<f32>; TERMS],
    /// Weight of each neighbour.
    pub(super) weights: Vec<f32>,
}

impl RowKernel {
    /// Computes the weights of the pixels at `offset` from those of row `y`, whose values 1/(2γ²) are `precisions`.
    /// The neighbouring row must lie inside.
    #[inline(always)]
    pub(super) fn compute(&mut self, primary: &Primary, y: usize, offset: [isize; 2], precisions: &[Vec<f32>; TERMS]) {
        let width = primary.size.width;
        let [dx, dy] = offset;
        self.columns = (-dx).max(0) as usize..(width as isize - dx.max(0)).max(0) as usize;
        let count = self.columns.len();
        let here = y * width + self.columns.start;
        let there = here.wrapping_add_signed(dx + dy * width as isize);
        self.distances.iter_mut().for_each(|distances| distances.resize(count, 0.0));
        self.weights.resize(count, 0.0);
        self.distances[SPACE].fill((dx * dx + dy * dy) as f32 / (SPACE_UNIT * SPACE_UNIT));
        colour_distances(primary, [here, there], &mut self.distances[COLOUR]);
        for kind in 0..FEATURES {
            feature_distances(primary, kind, [here, there], &mut self.distances[2 + kind]);
        }
        self.weights.fill(0.0);
        for (distances, precisions) in self.distances.iter().zip(precisions) {
            let precisions = &precisions[self.columns.start..][..count];
            for ((sum, distance), precision) in self.weights.iter_mut().zip(distances).zip(precisions) {
                *sum += distance * precision;
            }
        }
        self.weights.iter_mut().for_each(|w| *w = exp_of_negative(-*w));
    }
}

/// Squared difference of colours over the sum of both variances, mean over RGB.
#[inline(always)]
fn colour_distances(primary: &Primary, [here, there]: [usize; 2], out: &mut [f32]) {
    let count = out.len();
    let [r, g, b] = [0, 1, 2].map(|c| &primary.colour[c][here..][..count]);
    let [r2, g2, b2] = [0, 1, 2].map(|c| &primary.colour[c][there..][..count]);
    let (v, v2) = (&primary.colour_variance[here..][..count], &primary.colour_variance[there..][..count]);
    for i in 0..count {
        let (r, g, b) = (r[i] - r2[i], g[i] - g2[i], b[i] - b2[i]);
        out[i] = (r * r + g * g + b * b) / (3.0 * (v[i] + v2[i]));
    }
}

/// Squared difference of one kind of feature over the centre's ψ² + δ; zeros when the stack has not that kind.
#[inline(always)]
fn feature_distances(primary: &Primary, kind: usize, [here, there]: [usize; 2], out: &mut [f32]) {
    let count = out.len();
    out.fill(0.0);
    for plane in &primary.features[kind] {
        let (a, b) = (&plane[here..][..count], &plane[there..][..count]);
        for i in 0..count {
            out[i] += (a[i] - b[i]) * (a[i] - b[i]);
        }
    }
    if !primary.features[kind].is_empty() {
        let scale = &primary.feature_scale[kind][here..][..count];
        out.iter_mut().zip(scale).for_each(|(d, scale)| *d /= scale);
    }
}

/// 1/(2γ²) of each term for a row of pixels.
pub(super) fn precisions(bandwidths: &[Bandwidths]) -> [Vec<f32>; TERMS] {
    std::array::from_fn(|term| bandwidths.iter().map(|of| 0.5 / (of[term] * of[term])).collect())
}

/// Offsets of the (2·`radius` + 1)² window around row `y` whose rows lie inside a picture of `height` rows.
pub(super) fn offsets(y: usize, height: usize, radius: usize) -> impl Iterator<Item = [isize; 2]> {
    let rows = -(y.min(radius) as isize)..=(height - 1 - y).min(radius) as isize;
    let reach = radius as isize;
    rows.flat_map(move |dy| (-reach..=reach).map(move |dx| [dx, dy]))
}
