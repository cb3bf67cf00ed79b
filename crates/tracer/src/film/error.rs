//! Why a stack cannot become a film.

use stack::Fault;

/// A feature stack lacks what a film consists of, so no samples can be added to it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "this stack cannot be continued: {what} should be {expected}, found {found}; only stacks with all layers of an own \
     render can take more samples"
)]
pub struct NotAFilm {
    /// What is not as it should be.
    pub what: String,
    /// What a film has there.
    pub expected: String,
    /// What the stack has there.
    pub found: String,
}

impl NotAFilm {
    pub(super) fn new(what: impl Into<String>, expected: impl ToString, found: impl ToString) -> Self {
        Self { what: what.into(), expected: expected.to_string(), found: found.to_string() }
    }

    /// Whose fault it is.
    pub const fn fault(&self) -> Fault {
        Fault::Input
    }
}
