//! What a reader of files has to say that is not an error.

/// Things said once each, in order.
#[derive(Debug, Default)]
pub(super) struct Notes(Vec<String>);

impl Notes {
    /// Says something, unless it has been said.
    pub(super) fn add(&mut self, note: String) {
        if !self.0.contains(&note) {
            self.0.push(note);
        }
    }

    /// All that was said.
    pub(super) fn into_lines(self) -> Vec<String> {
        self.0
    }
}
