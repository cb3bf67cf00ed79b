//! Portable float maps: three (or one) 32-bit floats a pixel, bottom row first; and their half-precision form (PHM).

use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

use exr::prelude::{FlatSamples, f16};

use super::{Action, Carried, FileError, Layers, Passthrough, write_atomically};
use crate::{Image, Size, Window};

/// Reads a PFM or PHM (half precision) file of one or three channels; one is repeated in all three.
///
/// # Errors
/// When the file is absent, a folder, or not a whole PFM file.
pub fn read_pfm(path: &Path) -> Result<Image, FileError> {
    let mut layers = read_pfm_layers(path)?;
    let size = layers.window.size;
    let planes = match layers.take("Y") {
        Some(grey) => vec![grey; 3],
        None => ["R", "G", "B"].iter().filter_map(|name| layers.take(name)).collect(),
    };
    Ok(Image::from_channels(size, planes))
}

/// Whether a file that begins with `start` is one of these.
pub(super) fn is_pfm(start: &[u8]) -> bool {
    matches!(start, [b'P', b'F' | b'f' | b'H' | b'h', space, ..] if space.is_ascii_whitespace())
}

/// Reads such a file as channels `R G B` or `Y`, in its own number type.
///
/// # Errors
/// As [`read_pfm`].
pub(super) fn read_pfm_layers(path: &Path) -> Result<Layers, FileError> {
    if path.is_dir() {
        return Err(FileError::Folder { path: path.into() });
    }
    let bytes = std::fs::read(path).map_err(|source| FileError::io(path, Action::Read, source))?;
    let Shape { names, half, little, size, start } = shape(path, &bytes)?;
    let values = &bytes[start..];
    let value_bytes = if half { 2 } else { 4 };
    let wanted = size.width.checked_mul(size.height).and_then(|n| n.checked_mul(names.len() * value_bytes));
    if wanted.is_none_or(|wanted| values.len() < wanted) {
        return Err(damaged(path, "it ends before its last pixel"));
    }
    let channel = |(c, name): (usize, &&str)| {
        let Size { width, height } = size;
        let at = |i: usize| ((height - 1 - i / width) * width + i % width) * names.len() + c;
        let samples = if half {
            FlatSamples::F16((0..size.pixels()).map(|i| f16::from_bits(half_word(values, at(i), little))).collect())
        } else {
            FlatSamples::F32((0..size.pixels()).map(|i| f32::from_bits(word(values, at(i), little))).collect())
        };
        Passthrough { name: (*name).into(), samples }
    };
    Ok(layers(path, size, names.iter().enumerate().map(channel).collect()))
}

/// What [`read_pfm_layers`] would read of `path`, with one black pixel in place of the picture, and the picture's size.
///
/// # Errors
/// When the header cannot be understood.
pub(super) fn outline_pfm(path: &Path) -> Result<(Layers, Size), FileError> {
    let failed = |source| FileError::io(path, Action::Read, source);
    let mut start = Vec::new();
    File::open(path).and_then(|file| file.take(LONGEST_HEADER).read_to_end(&mut start)).map_err(failed)?;
    let Shape { names, half, size, .. } = shape(path, &start)?;
    let black = || if half { FlatSamples::F16(vec![f16::ZERO]) } else { FlatSamples::F32(vec![0.0]) };
    let channels = names.iter().map(|name| Passthrough { name: (*name).into(), samples: black() }).collect();
    Ok((layers(path, Size::new(1, 1), channels), size))
}

fn layers(path: &Path, size: Size, channels: Vec<Passthrough>) -> Layers {
    let (window, carried) = (Window::whole(size), Carried::default());
    Layers { path: path.into(), window, film: size, channels, metadata: None, carried }
}

fn damaged(path: &Path, reason: &str) -> FileError {
    FileError::Damaged { path: path.into(), format: "PFM", reason: reason.into() }
}

/// More bytes than four words and what stands between them take.
const LONGEST_HEADER: u64 = 1024;

/// What a header says.
struct Shape {
    names: &'static [&'static str],
    half: bool,
    little: bool,
    size: Size,
    /// Where the values start.
    start: usize,
}

fn shape(path: &Path, bytes: &[u8]) -> Result<Shape, FileError> {
    let (words, start) = header(bytes).ok_or_else(|| damaged(path, "expected a header of three lines"))?;
    let (names, half): (&'static [&'static str], bool) = match words[0] {
        "PF" => (&["R", "G", "B"], false),
        "Pf" => (&["Y"], false),
        "PH" => (&["R", "G", "B"], true),
        "Ph" => (&["Y"], true),
        _ => return Err(damaged(path, "expected PF, Pf, PH or Ph at the start")),
    };
    let number = |word: &str| word.parse::<usize>().ok().filter(|n| *n > 0);
    let (Some(width), Some(height)) = (number(words[1]), number(words[2])) else {
        return Err(damaged(path, "expected a width and a height"));
    };
    let scale: f32 = words[3].parse().map_err(|_| damaged(path, "expected a scale"))?;
    Ok(Shape { names, half, little: scale < 0.0, size: Size::new(width, height), start })
}

fn word(values: &[u8], at: usize, little: bool) -> u32 {
    let bytes = [0, 1, 2, 3].map(|i| values[4 * at + i]);
    if little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) }
}

fn half_word(values: &[u8], at: usize, little: bool) -> u16 {
    let bytes = [0, 1].map(|i| values[2 * at + i]);
    if little { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) }
}

/// The four words of the header, and where the values start, after the one white space that ends it.
fn header(bytes: &[u8]) -> Option<([&str; 4], usize)> {
    let mut rest = bytes;
    let mut words = [""; 4];
    for word in &mut words {
        let start = rest.iter().take(64).position(|b| !b.is_ascii_whitespace())?;
        let length = rest[start..].iter().take(64).position(u8::is_ascii_whitespace)?;
        *word = std::str::from_utf8(&rest[start..start + length]).ok()?;
        rest = &rest[start + length..];
    }
    Some((words, bytes.len() - rest.len() + 1))
}

/// Writes the first three channels of `image`, atomically.
///
/// # Errors
/// When the file cannot be written.
pub fn write_pfm(path: &Path, image: &Image) -> Result<(), FileError> {
    let size = image.size();
    write_atomically(path, |out| {
        let mut bytes = format!("PF\n{} {}\n-1.0\n", size.width, size.height).into_bytes();
        for y in (0..size.height).rev() {
            for x in 0..size.width {
                for value in image.rgb(size.index(x, y)) {
                    bytes.extend(value.to_le_bytes());
                }
            }
        }
        out.write_all(&bytes).map_err(|source| FileError::io(path, Action::Write, source))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.pfm");
        let size = Size::new(3, 2);
        let channels = (0..3).map(|c| (0..6).map(|i| (c * 10 + i) as f32 - 3.5).collect()).collect();
        let image = Image::from_channels(size, channels);
        write_pfm(&path, &image).unwrap();
        assert_eq!(read_pfm(&path).unwrap(), image);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
        assert!(read_pfm(&path).unwrap_err().to_string().contains("ends before its last pixel"));
    }

    #[test]
    fn half_precision_and_big_ends_are_understood() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.phm");
        let values = [1.5_f32, -2.0, 0.25, 8.0];
        let mut bytes = b"Ph\n2 2\n1.0\n".to_vec();
        values.iter().for_each(|v| bytes.extend(f16::from_f32(*v).to_bits().to_be_bytes()));
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(read_pfm(&path).unwrap().channels()[2], [0.25, 8.0, 1.5, -2.0], "the bottom row comes first");
    }
}
