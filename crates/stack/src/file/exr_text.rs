//! Text in EXR files: UTF-8, as OpenEXR has it.
//!
//! The `exr` crate takes every byte for a character of its own (Latin-1), and refuses all others.

use exr::prelude::Text;

/// `text` as it stands in a file.
pub fn encoded(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// What `bytes` of a file say; those of old programs, which are not UTF-8, as Latin-1.
pub fn decoded(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().copied().map(char::from).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_text_survives_and_old_files_are_understood() {
        assert_eq!(decoded(encoded("カラー é").bytes()), "カラー é");
        assert_eq!(decoded(b"caf\xe9"), "café");
    }
}
