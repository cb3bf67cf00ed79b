//! What of the meshes is left out.

/// Triangles dropped because no ray could hit them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Those without area.
    pub degenerate: usize,
    /// Those with a coordinate that is NaN, infinite or too large to compute with.
    pub not_finite: usize,
}

impl Dropped {
    /// One sentence for each kind that there is.
    pub(super) fn said(&self) -> Vec<String> {
        let kinds = [
            (self.degenerate, "without area"),
            (self.not_finite, "with coordinates that are NaN, infinite or too large"),
        ];
        let some = kinds.into_iter().filter(|(count, _)| *count > 0);
        some.map(|(count, what)| format!("{count} triangles {what} left out")).collect()
    }
}
