//! What can be wrong with a scene.

use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;

use stack::Fault;

use super::dropped::Dropped;
use crate::camera::CameraError;

/// A line of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: PathBuf,
    /// The line, from 1.
    pub line: usize,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file.display(), self.line)
    }
}

/// What is wrong with a scene.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A file is not there.
    #[error("{}: no such file; check the path, which is relative to the file that names it", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// A folder stands where a file should.
    #[error("{}: is a folder, expected a scene file (.obj, .gltf, .glb or .toml)", path.display())]
    IsFolder {
        /// The folder.
        path: PathBuf,
    },
    /// A file cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file's name does not say what it holds.
    #[error("{}: expected a file that ends in .obj, .gltf, .glb or .toml; convert other scenes to one of these", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// Nothing but blanks.
    #[error("{}: the file is empty, expected vertices and faces", path.display())]
    EmptyFile {
        /// The file.
        path: PathBuf,
    },
    /// No face to see.
    #[error("{}: has {vertices} vertices but no face with three corners", path.display())]
    NoFaces {
        /// The file.
        path: PathBuf,
        /// How many vertices it has.
        vertices: usize,
    },
    /// A line does not read as it should.
    #[error("{place}: expected {expected}, found {found}")]
    Malformed {
        /// Where.
        place: Place,
        /// What should stand there.
        expected: String,
        /// What stands there.
        found: String,
    },
    /// A glTF file that holds a mistake, or needs what is not supported.
    #[error("{}: {reason}", path.display())]
    BadGltf {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A name that is not known.
    #[error("{place}: there is no {what} '{name}'{}", nearest.as_ref().map_or(String::new(), |n| format!("; did you mean '{n}'?")))]
    UnknownName {
        /// Where.
        place: Place,
        /// What kind of name.
        what: Cow<'static, str>,
        /// The name.
        name: String,
        /// The known name most like it.
        nearest: Option<String>,
    },
    /// A camera that cannot be.
    #[error("{place}: {source}")]
    Camera {
        /// Where.
        place: Place,
        /// What is wrong.
        source: CameraError,
    },
    /// A texture that a scene file asks for is missing or cannot be read.
    #[error("{place}: {reason}")]
    BadTexture {
        /// Where it is asked for.
        place: Place,
        /// Which one, and why not.
        reason: String,
    },
    /// A picture that cannot be read.
    #[error(transparent)]
    Picture(#[from] stack::file::FileError),
    /// A picture that is none.
    #[error("{}: cannot be read as a picture: {reason}; convert it to .hdr or .exr", path.display())]
    BadPicture {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// An index in a mesh or instance points to nothing.
    #[error("{what} {index} does not exist: there are {count}")]
    BadIndex {
        /// What is missing.
        what: &'static str,
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// There is no triangle to see.
    #[error(
        "the scene has no visible triangle ({} without area and {} with impossible coordinates were dropped)",
        dropped.degenerate, dropped.not_finite
    )]
    Empty {
        /// Triangles that were dropped.
        dropped: Dropped,
    },
}

impl SceneError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Unreadable { .. } => Fault::Machine,
            Self::Picture(cause) => cause.fault(),
            _ => Fault::Input,
        }
    }
}
