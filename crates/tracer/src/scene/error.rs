//! What can be wrong with a scene.

use stack::Fault;

use super::Dropped;

/// What is wrong with a scene.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// An index in a mesh or instance points to nothing.
    #[error("{what} {index} does not exist: there are {count}")]
    BadIndex {
        /// What is missing.
        what: &'static str,
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// There is no triangle to see.
    #[error(
        "the scene has no visible triangle ({} without area and {} with impossible coordinates were dropped)",
        dropped.degenerate, dropped.not_finite
    )]
    Empty {
        /// Triangles that were dropped.
        dropped: Dropped,
    },
}

impl SceneError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        Fault::Input
    }
}
