//! Feature stacks as OpenEXR files.

use exr::prelude::FlatSamples;

/// A channel nobody here interprets, carried along with its name and its own number type.
#[derive(Clone, Debug, PartialEq)]
pub struct Passthrough {
    /// Full channel name.
    pub name: String,
    /// Values, row-major.
    pub samples: FlatSamples,
}
