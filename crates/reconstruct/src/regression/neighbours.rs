//! The neighbours of the pixels worked on side by side, as a fit looks at them.

use pulp::Simd;

use super::bandwidth::Projection;
use super::field::Field;
use super::window::Window;

/// The neighbours of the pixels worked on side by side, as a fit looks at them.
pub(crate) struct Neighbours<'a, S: Simd, T> {
    /// Their colours, and the variances of these.
    pub(crate) field: &'a Field,
    /// Where they are in the picture.
    pub(crate) window: &'a Window<S>,
    /// Where they are in the reduced space.
    pub(crate) projection: &'a Projection<S>,
    /// How many dimensions of that count.
    pub(crate) rank: usize,
    /// What their weights are multiplied by: a [`super::window::Trust`].
    pub(crate) trust: &'a T,
}
