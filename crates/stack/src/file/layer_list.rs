//! The channels of a file, gathered into layers.

use super::Layers;
use super::alias::{BIN, LONG_NAMES, SINGLES, TRIPLES};

/// Channels that stand on their own in front of the names of layers: those of the picture.
const BARE: [&str; 5] = ["R", "G", "B", "A", "Y"];

/// A layer: the text before the last dot, with the channels behind it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayerNames {
    /// Full name; empty for bare `R G B`.
    pub name: String,
    /// Its own name in lower case, without separators and without what stands before its last dot.
    pub key: String,
    /// What stands before its last dot.
    pub parent: String,
    /// Channels behind the dot; one of no name for a channel without a dot.
    suffixes: Vec<String>,
}

impl LayerNames {
    /// Full names of its channels as three, when it has three of a kind.
    pub fn triple(&self) -> Option<Vec<String>> {
        TRIPLES.iter().find_map(|triple| self.all(triple))
    }

    /// Full name of its one channel, or of the one that stands for all.
    pub fn single(&self) -> Option<Vec<String>> {
        if self.suffixes.iter().all(|suffix| suffix.starts_with(BIN)) {
            return self.suffixes.iter().max().map(|last| vec![self.full(last)]);
        }
        SINGLES.iter().find_map(|single| self.all(&[single]))
    }

    /// Full names of as many channels as asked for, 3 or 1.
    pub fn channels(&self, count: usize) -> Option<Vec<String>> {
        if count == 3 { self.triple() } else { self.single() }
    }

    /// Full name of the channel `suffix`, when it has it.
    pub fn channel(&self, suffix: &str) -> Option<String> {
        self.all(&[suffix])?.pop()
    }

    /// Whether it has all the channels `wanted`.
    pub fn has(&self, wanted: &[&str]) -> bool {
        self.all(wanted).is_some()
    }

    fn all(&self, wanted: &[&str]) -> Option<Vec<String>> {
        let named = |name: &str| self.suffixes.iter().find(|suffix| suffix.eq_ignore_ascii_case(name));
        let long = |w: &str| LONG_NAMES.iter().find(|(short, _)| *short == w).and_then(|(_, long)| named(long));
        let find = |w: &&str| named(w).or_else(|| long(w));
        wanted.iter().map(|w| find(w).map(|suffix| self.full(suffix))).collect()
    }

    fn full(&self, suffix: &str) -> String {
        match (self.name.as_str(), suffix) {
            ("", _) => suffix.into(),
            (name, "") => name.into(),
            (name, _) => format!("{name}.{suffix}"),
        }
    }
}

/// All layers of a file, in the order of their first channels.
pub fn layer_list(layers: &Layers) -> Vec<LayerNames> {
    layers_of(layers.channels.iter().map(|channel| channel.name.as_str()))
}

/// The layers that channels of these names make.
pub fn layers_of<'a>(channels: impl Iterator<Item = &'a str>) -> Vec<LayerNames> {
    let mut list: Vec<LayerNames> = Vec::new();
    for channel in channels {
        let (name, suffix) = match channel.rsplit_once('.') {
            Some((name, suffix)) => (name, suffix),
            None if BARE.contains(&channel) || channel.starts_with(BIN) => ("", channel),
            None => (channel, ""),
        };
        // `normal.X` and a channel `normal` are two things, but nobody writes both.
        match list.iter_mut().find(|layer| layer.name == name) {
            Some(layer) => layer.suffixes.push(suffix.into()),
            None => list.push(new_layer(name, suffix)),
        }
    }
    list
}

fn new_layer(name: &str, suffix: &str) -> LayerNames {
    let (parent, own) = name.rsplit_once('.').unwrap_or(("", name));
    LayerNames { name: name.into(), key: normalise(own), parent: parent.into(), suffixes: vec![suffix.into()] }
}

/// `text` in lower case, letters and digits only.
pub fn normalise(text: &str) -> String {
    text.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// The words `text` is made of, in lower case: cut at separators and where a capital follows a small letter.
pub fn words(text: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut small = false;
    for c in text.chars() {
        if !c.is_alphanumeric() || (small && c.is_uppercase()) {
            words.push(String::new());
        }
        if c.is_alphanumeric() {
            words.last_mut().into_iter().for_each(|word| word.extend(c.to_lowercase()));
        }
        small = c.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fall_into_words() {
        assert_eq!(words("ViewLayer.Denoising Normal"), ["view", "layer", "denoising", "normal"]);
        assert_eq!(words("AVG_SHADING_NORMAL"), ["avg", "shading", "normal"]);
        assert_eq!(normalise("Noisy Image"), "noisyimage");
    }
}
