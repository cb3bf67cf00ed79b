//! Where in a TOML file a mistake is, and what was meant.

use std::path::{Path, PathBuf};

use super::super::SceneError;
use super::super::error::Place;

/// A file's lines.
pub(super) struct Lines<'t> {
    text: &'t str,
    file: PathBuf,
}

impl<'t> Lines<'t> {
    /// The lines of `text`, the content of `file`.
    pub(super) fn new(text: &'t str, file: &Path) -> Self {
        Self { text, file: file.into() }
    }

    /// The line of the byte at `offset`.
    pub(super) fn line(&self, offset: usize) -> usize {
        let before = self.text.as_bytes().iter().take(offset);
        1 + before.filter(|&&byte| byte == b'\n').count()
    }

    /// The place of the byte at `offset`.
    pub(super) fn at(&self, offset: usize) -> Place {
        Place { file: self.file.clone(), line: self.line(offset) }
    }

    /// An error about what stands at `offset`.
    pub(super) fn malformed(&self, offset: usize, expected: &str, found: &str) -> SceneError {
        SceneError::Malformed { place: self.at(offset), expected: expected.into(), found: found.into() }
    }

    /// An error of the TOML reader in our words. Serde reports an unknown key as "unknown field `x`, expected one of
    /// `a`, `b`", a wrong value as "invalid type: x, expected y".
    pub(super) fn mistake(&self, error: &toml::de::Error) -> SceneError {
        let place = self.at(error.span().map_or(0, |span| span.start));
        let mut quoted = error.message().split('`').skip(1).step_by(2);
        let unknown = [("unknown field", "key"), ("unknown variant", "value")];
        let what = unknown.into_iter().find(|(words, _)| error.message().starts_with(words)).map(|(_, what)| what);
        if let (Some(what), Some(name)) = (what, quoted.next()) {
            let nearest = nearest(name, quoted);
            return SceneError::UnknownName { place, what: what.into(), name: name.into(), nearest };
        }
        let message = error.message().lines().next().unwrap_or_default();
        let missing = message.strip_prefix("missing field ").map(|key| ("none", format!("a key {key}")));
        let wrong = || message.split_once(", expected ").map(|(found, expected)| (bare(found), expected.to_string()));
        let (found, expected) = missing.or_else(wrong).unwrap_or((message, "a scene description".into()));
        SceneError::Malformed { place, expected, found: found.into() }
    }
}

/// What was found, without serde's word for what is wrong with it.
fn bare(found: &str) -> &str {
    let kinds = ["invalid type: ", "invalid value: ", "invalid "];
    kinds.iter().find_map(|kind| found.strip_prefix(kind)).unwrap_or(found)
}

/// The one of `known` that takes the fewest edits to become `name`.
pub fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<String> {
    known.min_by_key(|candidate| edit_distance(name, candidate)).map(str::to_owned)
}

/// How many characters must be inserted, removed or replaced to turn one word into the other (Levenshtein 1966).
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edit_distances_are_those_of_the_textbook() {
        for (a, b, distance) in [("kitten", "sitting", 3), ("", "abc", 3), ("flaw", "lawn", 2), ("fov", "fov", 0)] {
            assert_eq!(edit_distance(a, b), distance);
            assert_eq!(edit_distance(b, a), distance);
        }
    }

    #[test]
    fn lines_are_counted_from_one() {
        let lines = Lines::new("a\nb\n\nc", Path::new("f"));
        assert_eq!([0, 1, 2, 4, 5].map(|offset| lines.line(offset)), [1, 1, 2, 3, 4]);
    }
}
