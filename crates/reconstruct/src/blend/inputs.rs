//! What the network is told about a pixel.

use super::moments::{LEVELS, Moment, Moments};
use crate::ln::ln;

/// Numbers made of the moments on one scale.
const OF_SCALE: usize = 14;
/// Numbers of a pixel by itself.
const OWN: usize = 5;
/// All of them: each scale's, the whole picture's, its own.
pub const INPUTS: usize = (LEVELS + 1) * OF_SCALE + OWN;
/// Scale that a pixel by itself is compared with.
const MIDDLE: usize = 2;
/// Nothing is told that is further from 0.
const FURTHEST: f32 = 12.0;

/// Inputs of every pixel.
pub struct Inputs<'a> {
    moments: &'a Moments,
    whole: [f32; OF_SCALE],
}

impl<'a> Inputs<'a> {
    /// Made of these `moments`.
    pub fn new(moments: &'a Moments) -> Self {
        Self { moments, whole: of_scale(moments.whole) }
    }

    /// Pixels.
    pub fn pixels(&self) -> usize {
        self.moments.pixels()
    }

    /// What is told about `pixel`.
    pub fn at(&self, pixel: usize) -> [f32; INPUTS] {
        let mut inputs = [0.0; INPUTS];
        let mut parts = inputs.chunks_mut(OF_SCALE);
        for (scale, part) in (1..=LEVELS).zip(parts.by_ref()) {
            part.copy_from_slice(&of_scale(self.moments.at(scale, pixel)));
        }
        for (part, values) in parts.zip([&self.whole[..], &self.own(pixel)]) {
            part.copy_from_slice(values);
        }
        inputs.map(|value| value.clamp(-FURTHEST, FURTHEST))
    }

    /// How far the other and the noisy picture are from the picture here against around; noise; events.
    fn own(&self, pixel: usize) -> [f32; OWN] {
        let [noise, squared, ..] = self.moments.at(MIDDLE, pixel);
        let squared = squared + 1e-3 * noise + 1e-9;
        let [_, here, ..] = self.moments.at(0, pixel);
        let [d, r, events] = self.moments.single(pixel);
        [
            ln((here + 1e-3 * squared) / squared),
            d / squared.sqrt(),
            r / (noise + 1e-9).sqrt(),
            ln(noise + 1e-5),
            ln(events * events / (noise + 1e-9) + 1e-3),
        ]
    }
}

/// Ratios of moments: none depends on the unit of radiance.
fn of_scale(moment: Moment) -> [f32; OF_SCALE] {
    let [v, dd, dr, rr, error, sharp_d, sharp_dr, sharp_x, sharp_g, near, x, g] = moment;
    let v = v + 1e-9;
    let dd = dd + 1e-3 * v;
    [
        ln(dd / v),
        ln((error + 1e-4 * v) / v),
        ln((error + 0.01 * dd) / dd),
        dr / (dd * v).sqrt(),
        dr / dd,
        near / dd,
        (rr - v) / v,
        (rr - v) / (dd + 0.05 * v),
        ln((sharp_x + 1e-5 * v) / v),
        ln((sharp_g + 1e-5 * v) / v),
        ln((sharp_d + 1e-3 * dd) / dd),
        sharp_dr / (sharp_d + 1e-3 * v),
        sharp_dr / v,
        g / (x + 1e-6) - 1.0,
    ]
}
