//! What a reader of files has to say that is not an error.

/// Things said once each, in order.
#[derive(Debug, Default)]
pub(super) struct Notes {
    lines: Vec<String>,
    missing_textures: usize,
}

impl Notes {
    /// Says something, unless it has been said.
    pub(super) fn add(&mut self, note: String) {
        if !self.lines.contains(&note) {
            self.lines.push(note);
        }
    }

    /// Says that a texture is missing or cannot be read, and counts it, unless it has been said.
    pub(super) fn add_missing_texture(&mut self, note: String) {
        let before = self.lines.len();
        self.add(note);
        self.missing_textures += self.lines.len() - before;
    }

    /// Textures of materials that are missing or cannot be read.
    pub(super) fn missing_textures(&self) -> usize {
        self.missing_textures
    }

    /// All that was said.
    pub(super) fn into_lines(self) -> Vec<String> {
        self.lines
    }
}
