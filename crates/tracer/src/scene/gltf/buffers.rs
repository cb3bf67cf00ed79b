//! Bytes of a glTF file, wherever they are.

use std::path::{Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::buffer::{Source, View};

use super::super::find_file::find_file;

/// Padding or none.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// All buffers of a file.
pub(super) struct Buffers(Vec<Vec<u8>>);

/// Why there are no bytes.
pub(super) enum Missing {
    /// A file that is not there.
    File(PathBuf),
    /// In words.
    Other(String),
}

impl Buffers {
    /// Reads those of `document`; `blob` is the binary part of its file, files are looked for in `folder`.
    pub(super) fn read(document: &gltf::Document, mut blob: Option<&[u8]>, folder: &Path) -> Result<Self, Missing> {
        let mut all = Vec::with_capacity(document.buffers().len());
        for buffer in document.buffers() {
            let number = buffer.index();
            let other = |reason: String| Missing::Other(format!("buffers[{number}] {reason}"));
            let bytes = match buffer.source() {
                Source::Bin => blob.take().ok_or_else(|| other("has neither a uri nor a binary part".into()))?.to_vec(),
                Source::Uri(uri) => match embedded(uri) {
                    Some(bytes) => bytes.map_err(other)?,
                    None => read_file(uri, folder)?,
                },
            };
            if bytes.len() < buffer.length() {
                return Err(other(format!("has {} bytes, expected {}", bytes.len(), buffer.length())));
            }
            all.push(bytes);
        }
        Ok(Self(all))
    }

    /// How many bytes there are.
    pub(super) fn bytes(&self) -> usize {
        self.0.iter().map(Vec::len).sum()
    }

    /// The bytes of a view.
    ///
    /// # Errors
    /// In words, when it reaches beyond its buffer.
    pub(super) fn view(&self, view: &View) -> Result<&[u8], String> {
        let buffer = self.0[view.buffer().index()].as_slice();
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| buffer.get(view.offset()..end)).ok_or_else(|| {
            let (number, offset, length) = (view.index(), view.offset(), view.length());
            format!("bufferViews[{number}] spans {length} bytes from byte {offset} on of a buffer of {}", buffer.len())
        })
    }
}

/// The bytes that a `data:` URI holds; `None` when `uri` is none.
pub(super) fn embedded(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let (header, data) = uri.strip_prefix("data:")?.split_once(',').unwrap_or_default();
    if !header.ends_with(";base64") {
        return Some(Err("is embedded in a way that is not supported, expected ;base64".into()));
    }
    Some(BASE64.decode(data.trim()).map_err(|error| format!("is embedded with a mistake: {error}")))
}

/// The name of the file that `uri` means.
pub(super) fn file_name(uri: &str) -> String {
    percent_encoding::percent_decode_str(uri).decode_utf8_lossy().into_owned()
}

fn read_file(uri: &str, folder: &Path) -> Result<Vec<u8>, Missing> {
    let name = file_name(uri);
    let path = find_file(folder, &name).ok_or_else(|| Missing::File(folder.join(&name)))?;
    std::fs::read(&path).map_err(|error| Missing::Other(format!("{}: cannot be read: {error}", path.display())))
}
