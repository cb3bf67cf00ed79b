//! Why stacks cannot be added up.

use std::path::{Path, PathBuf};

use super::Difference;
use crate::Fault;

/// Stacks that are no samples of one picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// Another program wrote it.
    #[error(
        "{path}: not written by Tamis, so nothing tells which samples it holds; `denoise --buckets` takes other \
         renderers' files"
    )]
    NotOurs {
        /// The file.
        path: PathBuf,
    },
    /// It holds a picture only.
    #[error(
        "{path}: holds no samples, only what was made of them; it must be written with the layers `inputs` (--aov)"
    )]
    NoInputs {
        /// The file.
        path: PathBuf,
    },
    /// It is no render, or an old one.
    #[error("{path}: does not say which samples of which scene it holds, as renders of this version do")]
    NoRecord {
        /// The file.
        path: PathBuf,
    },
    /// It shows something else, or has other layers.
    #[error(
        "{path}: {}: expected {} as in {like}, found {}",
        difference.field, difference.expected, difference.found
    )]
    Differs {
        /// The file.
        path: PathBuf,
        /// The one it should agree with.
        like: PathBuf,
        /// In what it does not.
        difference: Box<Difference>,
    },
    /// It holds samples that are there already.
    #[error(
        "{path}: holds the samples {first}..{end} of seed {seed}, but {like} holds {like_first}..{like_end}: the same \
         samples count once only"
    )]
    Overlap {
        /// The file.
        path: PathBuf,
        /// The one that has them already.
        like: PathBuf,
        /// Their seed.
        seed: u64,
        /// First sample of the file's range.
        first: u32,
        /// The one after its last.
        end: u32,
        /// First sample of the other's.
        like_first: u32,
        /// The one after the other's last.
        like_end: u32,
    },
}

impl MergeError {
    /// Whose fault it is.
    pub const fn fault(&self) -> Fault {
        Fault::Input
    }

    pub(super) fn differs(path: &Path, like: &Path, difference: Difference) -> Self {
        Self::Differs { path: path.into(), like: like.into(), difference: Box::new(difference) }
    }
}
