//! Which channels of a file are read: of our own, no more than is needed.

use std::collections::HashSet;
use std::path::Path;

use super::own::{belongs, header_of, is_own, is_own_channel, is_result};
use super::write::{SAMPLES, input_layers};
use super::{FileError, Layers};
use crate::{GATHERED, INDIRECT, Size};

/// What is taken from a file of ours, beside what is carried along. Of another program's, it is all.
#[derive(Clone, Copy, Debug)]
pub enum Taken<'a> {
    /// All: it is a file like any other.
    Everything,
    /// What a reconstruction starts from, and not what one has made of it; but for these layers.
    InputsBut(&'a [&'static str]),
    /// Means of the components and features, and how many samples they are of.
    Means,
}

impl Taken<'_> {
    /// Whether the channel `name` of a file of ours is taken.
    fn wants(self, name: &str) -> bool {
        match self {
            Self::Everything => true,
            Self::InputsBut(layers) => !is_result(name) && !layers.iter().any(|layer| belongs(name, layer)),
            Self::Means => !is_own_channel(name) || is_mean(name),
        }
    }

    /// Whether this is a file to choose from.
    fn chooses(self, layers: &Layers) -> Result<bool, FileError> {
        Ok(match self {
            Self::Everything => false,
            Self::InputsBut(_) => is_own(layers) && header_of(layers)?.is_some(),
            Self::Means => is_own(layers),
        })
    }
}

fn is_mean(name: &str) -> bool {
    let Some((layer, _)) = name.rsplit_once('.') else { return false };
    layer == SAMPLES || input_layers().any(|input| layer == input && ![INDIRECT, GATHERED].contains(&input))
}

/// As [`Layers::read`], of the channels `taken`.
///
/// # Errors
/// As there.
pub fn read_taken(path: &Path, taken: Taken<'_>) -> Result<Layers, FileError> {
    let (layers, _) = outline_taken(path, taken)?;
    let names: HashSet<&str> = layers.channels.iter().map(|channel| channel.name.as_str()).collect();
    Layers::read_some(path, &|name| names.contains(name))
}

/// As [`Layers::outline`], of the channels `taken`.
///
/// # Errors
/// As there.
pub fn outline_taken(path: &Path, taken: Taken<'_>) -> Result<(Layers, Size), FileError> {
    let (mut layers, size) = Layers::outline(path)?;
    if taken.chooses(&layers)? {
        layers.channels.retain(|channel| taken.wants(&channel.name));
    }
    Ok((layers, size))
}
