//! Texture statements: options and a file name.

use glam::Vec2;

/// What a `map_…` statement says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TextureLine {
    /// File name as written, blanks and all.
    pub(super) file: String,
    /// `-s`: how often the image repeats over one unit of the texture coordinates.
    pub(super) scale: Vec2,
    /// `-o`: what is added to the scaled texture coordinates.
    pub(super) offset: Vec2,
}

impl TextureLine {
    /// Reads options and file name; `None` without a file name.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let mut line = Self { file: String::new(), scale: Vec2::ONE, offset: Vec2::ZERO };
        let mut rest = text.trim();
        while let Some((option, after)) = rest.strip_prefix('-').and_then(|r| r.split_once(char::is_whitespace)) {
            rest = after.trim_start();
            match option {
                "s" => rest = take_vector(rest, &mut line.scale),
                "o" => rest = take_vector(rest, &mut line.offset),
                "t" => rest = take_vector(rest, &mut Vec2::ZERO.clone()),
                "mm" => rest = skip_words(rest, 2),
                "blendu" | "blendv" | "cc" | "clamp" | "texres" | "bm" | "boost" | "imfchan" | "type" => {
                    rest = skip_words(rest, 1);
                }
                _ => break,
            }
        }
        line.file = rest.trim_matches(['"', ' ', '\t']).into();
        (!line.file.is_empty()).then_some(line)
    }
}

/// Takes one to three numbers from the front of `text`; the first two go to `vector`.
fn take_vector<'a>(mut text: &'a str, vector: &mut Vec2) -> &'a str {
    for axis in 0..3 {
        let (word, after) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let Ok(number) = word.parse::<f32>() else { break };
        if axis < 2 {
            vector[axis] = number;
        }
        text = after.trim_start();
    }
    text
}

fn skip_words(mut text: &str, count: usize) -> &str {
    for _ in 0..count {
        text = text.split_once(char::is_whitespace).map_or("", |(_, after)| after.trim_start());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_taken_off_the_file_name() {
        let plain = TextureLine { file: "a b.png".into(), scale: Vec2::ONE, offset: Vec2::ZERO };
        assert_eq!(TextureLine::parse(" a b.png "), Some(plain.clone()));
        assert_eq!(TextureLine::parse("-blendu on -texres 512 -mm 0.1 2 a b.png"), Some(plain.clone()));
        let scaled = TextureLine { scale: Vec2::new(2.0, 3.0), offset: Vec2::new(0.5, 0.0), ..plain };
        assert_eq!(TextureLine::parse("-s 2 3 1 -o .5 -clamp off a b.png"), Some(scaled));
        assert_eq!(TextureLine::parse("-s 2 1 1"), None);
        assert_eq!(TextureLine::parse(""), None);
    }
}
