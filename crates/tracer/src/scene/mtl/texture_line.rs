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
    /// `-clamp on`: whether the image ends at its border.
    pub(super) clamp: bool,
    /// `-bm`: how many texels wide a bump of height 1 is high.
    pub(super) bump: f32,
    /// `-imfchan`: which channel a single number is taken from, where it is said.
    pub(super) channel: Option<Channel>,
}

/// Where a texture of single numbers takes them from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Channel {
    Red,
    Green,
    Blue,
    /// `m`, the matte.
    Alpha,
    /// `l`, and `z`, which no picture has.
    Luminance,
}

impl Channel {
    fn named(letter: &str) -> Option<Self> {
        match letter {
            "r" => Some(Self::Red),
            "g" => Some(Self::Green),
            "b" => Some(Self::Blue),
            "m" => Some(Self::Alpha),
            "l" | "z" => Some(Self::Luminance),
            _ => None,
        }
    }
}

impl TextureLine {
    /// A texture without options.
    pub(super) const fn plain(file: String) -> Self {
        Self { file, scale: Vec2::ONE, offset: Vec2::ZERO, clamp: false, bump: 1.0, channel: None }
    }

    /// Reads options and file name; `None` without a file name.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let mut line = Self::plain(String::new());
        let mut rest = text.trim();
        while let Some((option, after)) = rest.strip_prefix('-').and_then(|r| r.split_once(char::is_whitespace)) {
            rest = after.trim_start();
            match option {
                "s" => rest = take_vector(rest, &mut line.scale),
                "o" => rest = take_vector(rest, &mut line.offset),
                "t" => rest = take_vector(rest, &mut Vec2::ZERO.clone()),
                "mm" => rest = skip_words(rest, 2),
                "clamp" => rest = take_word(rest, |word| line.clamp = word.eq_ignore_ascii_case("on")),
                "bm" => rest = take_word(rest, |word| line.bump = word.parse().unwrap_or(1.0)),
                "imfchan" => rest = take_word(rest, |word| line.channel = Channel::named(word)),
                "blendu" | "blendv" | "cc" | "texres" | "boost" | "type" => rest = skip_words(rest, 1),
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

/// Takes one word from the front of `text`.
fn take_word(text: &str, mut take: impl FnMut(&str)) -> &str {
    let (word, after) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    take(word);
    after.trim_start()
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
        let plain = TextureLine::plain("a b.png".into());
        assert_eq!(TextureLine::parse(" a b.png "), Some(plain.clone()));
        assert_eq!(TextureLine::parse("-blendu on -texres 512 -mm 0.1 2 a b.png"), Some(plain.clone()));
        let scaled = TextureLine { scale: Vec2::new(2.0, 3.0), offset: Vec2::new(0.5, 0.0), ..plain.clone() };
        assert_eq!(TextureLine::parse("-s 2 3 1 -o .5 -clamp off a b.png"), Some(scaled));
        let bump = TextureLine { clamp: true, bump: 0.25, channel: Some(Channel::Alpha), ..plain };
        assert_eq!(TextureLine::parse("-clamp on -bm .25 -imfchan m a b.png"), Some(bump));
        assert_eq!(TextureLine::parse("-s 2 1 1"), None);
        assert_eq!(TextureLine::parse(""), None);
    }
}
