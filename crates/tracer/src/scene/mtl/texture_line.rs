//! Texture statements: options and a file name.

use glam::{Mat2, Vec2};

use super::super::textures::{Channel, TextureUse};
use crate::texture::Wrap;

/// Reads the options and the file name of a `map_…` statement; `None` without a file name.
pub(super) fn parse(text: &str) -> Option<TextureUse> {
    let mut line = TextureUse::plain(String::new());
    let mut rest = text.trim();
    while let Some((option, after)) = rest.strip_prefix('-').and_then(|r| r.split_once(char::is_whitespace)) {
        rest = after.trim_start();
        match option {
            "s" => {
                let mut scale = Vec2::ONE;
                rest = take_vector(rest, &mut scale);
                line.map = Mat2::from_diagonal(scale);
            }
            "o" => rest = take_vector(rest, &mut line.offset),
            "t" => rest = take_vector(rest, &mut Vec2::ZERO.clone()),
            "mm" => rest = skip_words(rest, 2),
            "clamp" => {
                rest = take_word(rest, |word| {
                    let wrap = if word.eq_ignore_ascii_case("on") { Wrap::Clamp } else { Wrap::Repeat };
                    line.wrap = [wrap; 2];
                });
            }
            "bm" => rest = take_word(rest, |word| line.strength = word.parse().unwrap_or(1.0)),
            "imfchan" => rest = take_word(rest, |word| line.channel = channel(word)),
            "blendu" | "blendv" | "cc" | "texres" | "boost" | "type" | "colorspace" => rest = skip_words(rest, 1),
            _ => break,
        }
    }
    line.file = rest.trim_matches(['"', ' ', '\t']).into();
    (!line.file.is_empty()).then_some(line)
}

/// The channel that `-imfchan` names: `m` is the matte, and `z` is what no picture has.
fn channel(letter: &str) -> Option<Channel> {
    match letter {
        "r" => Some(Channel::Red),
        "g" => Some(Channel::Green),
        "b" => Some(Channel::Blue),
        "m" => Some(Channel::Alpha),
        "l" | "z" => Some(Channel::Luminance),
        _ => None,
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
        let plain = TextureUse::plain("a b.png".into());
        assert_eq!(parse(" a b.png "), Some(plain.clone()));
        assert_eq!(parse("-blendu on -colorspace sRGB -texres 512 -mm 0.1 2 a b.png"), Some(plain.clone()));
        let scaled =
            TextureUse { map: Mat2::from_diagonal(Vec2::new(2.0, 3.0)), offset: Vec2::new(0.5, 0.0), ..plain.clone() };
        assert_eq!(parse("-s 2 3 1 -o .5 -clamp off a b.png"), Some(scaled));
        let bump = TextureUse { wrap: [Wrap::Clamp; 2], strength: 0.25, channel: Some(Channel::Alpha), ..plain };
        assert_eq!(parse("-clamp on -bm .25 -imfchan m a b.png"), Some(bump));
        assert_eq!(parse("-s 2 1 1"), None);
        assert_eq!(parse(""), None);
    }
}
