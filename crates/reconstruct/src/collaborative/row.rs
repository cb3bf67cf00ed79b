//! What a fit knows of a pixel, in one cache line.

use stack::Image;

use crate::prefilter::FeatureSet;

/// Most features a fit can use.
pub const FEATURES: usize = 10;

/// Values that are fitted side by side: the colours of both halves.
pub const RESPONSES: usize = 6;

/// Numbers in a row.
pub const WIDTH: usize = FEATURES + RESPONSES;

/// Features, then responses. Features that a stack does not have are zero.
pub type Row = [f32; WIDTH];

/// One row per pixel.
///
/// # Panics
/// When there are more features than fit, or planes differ in size: mistakes in the calling code.
pub fn rows_of(features: &FeatureSet, halves: [&Image; 2]) -> Vec<Row> {
    assert!(features.planes.len() <= FEATURES, "a row holds {FEATURES} features");
    let mut rows = vec![[0.0; WIDTH]; features.size.pixels()];
    let responses = halves.iter().flat_map(|half| half.channels());
    let places = (0..features.planes.len()).chain(FEATURES..WIDTH);
    for (place, plane) in places.zip(features.planes.iter().chain(responses)) {
        rows.iter_mut().zip(plane).for_each(|(row, value)| row[place] = *value);
    }
    rows
}
