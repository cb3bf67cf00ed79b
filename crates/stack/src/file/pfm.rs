//! Portable float maps: three (or one) 32-bit floats a pixel, bottom row first.

use std::io::Write;
use std::path::Path;

use super::{FileError, write_atomically};
use crate::{Image, Size};

/// Reads a PFM file of one or three channels; one is repeated in all three.
///
/// # Errors
/// When the file is absent, a folder, or not a whole PFM file.
pub fn read_pfm(path: &Path) -> Result<Image, FileError> {
    let damaged = |reason: &str| FileError::Damaged { path: path.into(), format: "PFM", reason: reason.into() };
    if path.is_dir() {
        return Err(FileError::Folder { path: path.into() });
    }
    let bytes = std::fs::read(path).map_err(|source| FileError::io(path, "read", source))?;
    let (words, values) = header(&bytes).ok_or_else(|| damaged("expected a header of three lines"))?;
    let channels = match words[0] {
        "PF" => 3,
        "Pf" => 1,
        _ => return Err(damaged("expected PF or Pf at the start")),
    };
    let number = |word: &str| word.parse::<usize>().ok().filter(|n| *n > 0);
    let (Some(width), Some(height)) = (number(words[1]), number(words[2])) else {
        return Err(damaged("expected a width and a height"));
    };
    let scale: f32 = words[3].parse().map_err(|_| damaged("expected a scale"))?;
    let wanted = width.checked_mul(height).and_then(|n| n.checked_mul(channels * 4));
    if wanted.is_none_or(|wanted| values.len() < wanted) {
        return Err(damaged("it ends before its last pixel"));
    }
    let read = if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let size = Size::new(width, height);
    let mut image = Image::zeros(size, 3);
    for (i, value) in values.chunks_exact(4).take(size.pixels() * channels).enumerate() {
        let (pixel, channel) = (i / channels, i % channels);
        let at = size.index(pixel % width, height - 1 - pixel / width);
        let value = read([value[0], value[1], value[2], value[3]]);
        if channels == 3 {
            image.channels_mut()[channel][at] = value;
        } else {
            image.channels_mut().iter_mut().for_each(|plane| plane[at] = value);
        }
    }
    Ok(image)
}

/// The four words of the header, and the bytes after the one white space that ends it.
fn header(bytes: &[u8]) -> Option<([&str; 4], &[u8])> {
    let mut rest = bytes;
    let mut words = [""; 4];
    for word in &mut words {
        let start = rest.iter().take(64).position(|b| !b.is_ascii_whitespace())?;
        let length = rest[start..].iter().take(64).position(u8::is_ascii_whitespace)?;
        *word = std::str::from_utf8(&rest[start..start + length]).ok()?;
        rest = &rest[start + length..];
    }
    Some((words, &rest[1..]))
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
        out.write_all(&bytes).map_err(|source| FileError::io(path, "write", source))
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
}
