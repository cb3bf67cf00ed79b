//! Features, normalised and freed of noise before the regression uses them.

use std::ops::Range;

use stack::Size;

/// Features ready for regression: one plane per channel, all on comparable scales.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureSet {
    /// Width and height of every plane.
    pub size: Size,
    /// One plane per feature channel, row-major, normalised to [−1, 1].
    pub planes: Vec<Vec<f32>>,
    /// Which planes belong together (position, albedo, normal, …).
    pub groups: Vec<Range<usize>>,
}
