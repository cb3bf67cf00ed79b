//! Wavefront OBJ files.
//!
//! The text is cut into pieces at the ends of lines, which are parsed side by side (`piece`) and put together in order
//! (`assemble`): indices may point ahead, so they can be checked only when all pieces are there. `polygon` cuts faces
//! into triangles.

mod assemble;
mod piece;
mod polygon;

use std::path::Path;

use rayon::prelude::*;

use super::error::Place;
use super::mtl::MtlLibrary;
use super::notes::Notes;
use super::source::read_text;
use super::{Mesh, SceneError};
use crate::material::Material;
use assemble::assemble;
use piece::{Counts, Mistake, Piece, find_out_of_range};

/// Triangles and materials of an OBJ file.
#[derive(Debug)]
pub(super) struct ObjFile {
    /// All triangles.
    pub(super) mesh: Mesh,
    /// What `mesh` indexes.
    pub(super) materials: Vec<Material>,
}

/// Bytes of a piece, about: enough that parsing outweighs everything else, and few enough that all threads get some.
const PIECE: usize = 1 << 20;

/// Reads an OBJ file and the materials it names. What is missing but not vital goes to `notes`.
///
/// # Errors
/// When the file cannot be read, has no face, or a line is malformed or points to a vertex that does not exist.
pub(super) fn read_obj(path: &Path, notes: &mut Notes) -> Result<ObjFile, SceneError> {
    let pieces = read_pieces(path)?;
    let vertices = pieces.iter().map(|piece| piece.positions.len()).sum();
    let mut library = MtlLibrary::new(path.parent().unwrap_or(Path::new("")).into());
    let mesh = assemble(pieces, &mut library, path, notes);
    if mesh.triangles.is_empty() {
        return Err(SceneError::NoFaces { path: path.into(), vertices });
    }
    let materials = library.into_materials(&mesh.materials, notes)?;
    Ok(ObjFile { mesh, materials })
}

/// The pieces of a file, all their indices counted from the file's first vertex.
fn read_pieces(path: &Path) -> Result<Vec<Piece>, SceneError> {
    let text = read_text(path)?;
    if text.trim().is_empty() {
        return Err(SceneError::EmptyFile { path: path.into() });
    }
    parse(&text, PIECE, path)
}

/// The same of `text`, the content of `path`, in pieces of about `size` bytes.
fn parse(text: &str, size: usize, path: &Path) -> Result<Vec<Piece>, SceneError> {
    let texts = cut(text, size);
    let mut pieces: Vec<Piece> = texts.par_iter().map(|text| Piece::parse(text)).collect();
    let fault = |line: usize, mistake: Mistake| SceneError::Malformed {
        place: Place { file: path.into(), line: line + mistake.line },
        expected: mistake.expected,
        found: mistake.found,
    };
    let lines_before = sums_before(&pieces, |piece| [piece.lines; 3]).0;
    let malformed =
        pieces.iter_mut().zip(&lines_before).find_map(|(piece, [line, ..])| Some((*line, piece.mistake.take()?)));
    if let Some((line, mistake)) = malformed {
        return Err(fault(line, mistake));
    }
    let (before, total) = sums_before(&pieces, Piece::counts);
    let sound: Vec<bool> =
        pieces.par_iter_mut().zip(&before).map(|(piece, before)| piece.make_absolute(*before, total)).collect();
    if let Some(first) = sound.iter().position(|sound| !sound)
        && let Some(mistake) = find_out_of_range(texts[first], before[first], total)
    {
        return Err(fault(lines_before[first][0], mistake));
    }
    Ok(pieces)
}

/// For each piece the sums of what `of` tells of those before it; and the sums of all.
fn sums_before(pieces: &[Piece], of: impl Fn(&Piece) -> Counts) -> (Vec<Counts>, Counts) {
    let mut sum = Counts::default();
    let add = |piece: &Piece| {
        let before = sum;
        sum = std::array::from_fn(|i| before[i] + of(piece)[i]);
        before
    };
    (pieces.iter().map(add).collect(), sum)
}

/// Cuts `text` at ends of lines into pieces of `size` bytes or somewhat more. A line that a backslash continues is not cut.
fn cut(text: &str, size: usize) -> Vec<&str> {
    let (mut pieces, mut rest) = (vec![], text);
    while !rest.is_empty() {
        let ends = rest.as_bytes().iter().enumerate().skip(size).filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at);
        let end = ends.into_iter().find(|&at| !rest[..at].trim_end().ends_with('\\')).map_or(rest.len(), |at| at + 1);
        let (piece, after) = rest.split_at(end);
        pieces.push(piece);
        rest = after;
    }
    pieces
}

#[cfg(test)]
mod tests;
