//! What can go wrong with a stack's file.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::merge::MergeError;
use crate::{Fault, Size};

/// What was tried with a file. What cannot be read is a mistake of whoever named it, what cannot be written the machine's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// To open it, or take bytes from it.
    Read,
    /// To make it, or put bytes into it.
    Write,
}

impl std::fmt::Display for Action {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Read => "read",
            Self::Write => "write",
        })
    }
}

/// A file could not be read or written as a picture or stack.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The file system refused.
    #[error("{path}: cannot {action}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried.
        action: Action,
        /// Why not.
        source: std::io::Error,
    },
    /// A folder was given where a file is needed.
    #[error("{path}: expected a file, found a folder")]
    Folder {
        /// The folder.
        path: PathBuf,
    },
    /// The bytes are not a picture of the expected format, or are cut short.
    #[error("{path}: not a readable {format} file: {reason}")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What was expected.
        format: &'static str,
        /// What is wrong with it.
        reason: String,
    },
    /// The file is well formed, but of a kind that is not supported.
    #[error("{path}: {what} are not supported; {remedy}")]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The kind.
        what: String,
        /// What to do instead.
        remedy: &'static str,
    },
    /// The picture does not fit into memory.
    #[error(
        "{path}: {width}x{height} pixels need {needed} bytes of memory, {available} are free; crop it or leave out channels"
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its width.
        width: usize,
        /// Its height.
        height: usize,
        /// Bytes its channels need.
        needed: u128,
        /// Bytes there are.
        available: u64,
    },
    /// A needed layer is absent.
    #[error("{path}: no {wanted}; expected channels {expected}, found {found}")]
    Missing {
        /// The file.
        path: PathBuf,
        /// The role that was looked for.
        wanted: &'static str,
        /// Channel names that would do.
        expected: String,
        /// Channel names there are.
        found: String,
    },
    /// A layer that the user named is not there.
    #[error("{path}: --map {slot}={layer}: no layer of {count} channels begins so; there are {found}")]
    NoSuchLayer {
        /// The file.
        path: PathBuf,
        /// The role it was to have.
        slot: String,
        /// The name given.
        layer: String,
        /// How many channels it should have.
        count: usize,
        /// Layers there are.
        found: String,
    },
    /// Several layers have an equal claim to a role.
    #[error(
        "{path}: several layers could be {slot}: {candidates}; choose one with --map {slot}=LAYER{}",
        or_none(slot)
    )]
    Ambiguous {
        /// The file.
        path: PathBuf,
        /// The role.
        slot: String,
        /// The layers.
        candidates: String,
    },
    /// It is said of a file of ours what it is.
    #[error("{path}: was written by Tamis and says itself what it holds; leave {flag} away")]
    SaysItself {
        /// The file.
        path: PathBuf,
        /// What was said.
        flag: &'static str,
    },
    /// Files that are no stack together.
    #[error("{reason}; say what they are with role=FILE, or give a folder as output for several pictures")]
    Unclear {
        /// What is unclear about them.
        reason: String,
    },
    /// Two files that belong together have different sizes.
    #[error("{path}: expected {expected} pixels as in {like}, found {found}")]
    SizeDiffers {
        /// The file that differs.
        path: PathBuf,
        /// The file it should agree with.
        like: PathBuf,
        /// Size of `like`.
        expected: Size,
        /// Size of `path`.
        found: Size,
    },
    /// Two files that belong together show different parts of the picture.
    #[error(
        "{path}: expected pixels from {},{} on as in {like}, found some from {},{} on; give crops of the same place",
        expected[0], expected[1], found[0], found[1]
    )]
    PlaceDiffers {
        /// The file that differs.
        path: PathBuf,
        /// The file it should agree with.
        like: PathBuf,
        /// Column and row of `like`'s first pixel.
        expected: [i32; 2],
        /// Column and row of `path`'s first pixel.
        found: [i32; 2],
    },
    /// Two buckets hold the very same noise, so they are no independent measurements.
    #[error("{first} and {second} hold identical noise; buckets must be independent renders (use another seed)")]
    SameNoise {
        /// One file.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
    /// Slices that cannot be added up.
    #[error(transparent)]
    Merge(#[from] MergeError),
    /// Sample counts that are neither one for all nor one for each.
    #[error("--spp: {given} numbers for {renders}; expected one for all, or one for each half or bucket")]
    SampleCounts {
        /// How many numbers were given.
        given: usize,
        /// What they are for.
        renders: String,
    },
    /// Fewer buckets than any noise estimate needs.
    #[error("{found} bucket given, at least 2 are needed; give more independent renders of the same picture")]
    TooFewBuckets {
        /// How many there are.
        found: usize,
    },
}

/// What else `--map` may say of a role: nothing is a picture without colour.
fn or_none(slot: &str) -> &'static str {
    if slot == "colour" { "" } else { " (or none)" }
}

impl FileError {
    /// Whose fault this is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Io { action: Action::Read, .. } => Fault::Input,
            // A folder that is not there is no failure of the machine.
            Self::Io { source, .. } if matches!(source.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
                Fault::Usage
            }
            Self::Io { action: Action::Write, .. } => Fault::Machine,
            Self::TooFewBuckets { .. } | Self::Unclear { .. } | Self::SampleCounts { .. } | Self::SaysItself { .. } => {
                Fault::Usage
            }
            Self::Merge(cause) => cause.fault(),
            _ => Fault::Input,
        }
    }

    pub(super) fn io(path: &Path, action: Action, source: std::io::Error) -> Self {
        Self::Io { path: path.into(), action, source }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tie_may_be_settled_by_none_but_for_colour() {
        let tie = |slot: &str| FileError::Ambiguous {
            path: "a.exr".into(),
            slot: slot.into(),
            candidates: "'x', 'y'".into(),
        };
        assert!(tie("albedo").to_string().ends_with("choose one with --map albedo=LAYER (or none)"));
        assert!(tie("colour").to_string().ends_with("choose one with --map colour=LAYER"));
    }
}
