//! How many numbers a fit knows of a pixel.

/// Most features a fit can use.
pub const FEATURES: usize = 12;

/// Most values that are fitted side by side: the colours of both halves.
pub const RESPONSES: usize = 6;

/// Features and responses together.
pub const WIDTH: usize = FEATURES + RESPONSES;

/// Features, then responses. What there is less of is zero.
pub type Row = [f32; WIDTH];
