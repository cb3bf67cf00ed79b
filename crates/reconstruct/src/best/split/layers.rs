//! The two layers.

use std::ops::Range;

use stack::Image;

use crate::bands::image_rows;

/// Least variance of a half.
pub const LEAST_VARIANCE: f32 = 1e-7;

/// A component in two layers.
#[derive(Clone, Debug)]
pub struct Layers {
    /// What regressions rebuild.
    pub low: LowLayer,
    /// What was cut off.
    pub events: Events,
}

/// The low layer, which a regression can follow.
#[derive(Clone, Debug)]
pub struct LowLayer {
    /// Its half-buffers.
    pub halves: [Image; 2],
    /// Variance of a half's mean, ½ its own and ½ that of 3×3 pixels.
    pub variance: Image,
}

impl LowLayer {
    /// Some `rows` of it.
    pub fn rows(&self, rows: &Range<usize>) -> Self {
        let Self { halves, variance } = self;
        Self { halves: halves.each_ref().map(|image| image_rows(image, rows)), variance: image_rows(variance, rows) }
    }
}

/// The sparse layer. An event is what was cut off one bucket at one pixel.
#[derive(Clone, Debug)]
pub struct Events {
    /// What was cut off the buckets of either half, divided by all samples of the pixel; three channels each. Their sum
    /// is what the mean lacks.
    pub light: [Image; 2],
    /// Σ e over a pixel's events, e the RGB sum of one.
    pub energy: Vec<f32>,
    /// Σ e².
    pub squares: Vec<f32>,
}

impl Events {
    /// Σe²/(Σe)² of a pixel's events: one over how many equal ones they count for.
    pub fn concentration(&self, pixel: usize) -> f32 {
        self.squares[pixel] / (self.energy[pixel] * self.energy[pixel]).max(f32::MIN_POSITIVE)
    }
}
