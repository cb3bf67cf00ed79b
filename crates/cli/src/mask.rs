//! The pixels that `compare` leaves out.

use std::path::Path;

use anyhow::Result;
use stack::file::{Layers, extension, read_pfm};
use stack::{Image, Size};

use crate::any_picture::decode;
use crate::failure::usage;

/// Reads a picture of `size` as a mask: `false` where all its channels but alpha are 0.
///
/// # Errors
/// When the file cannot be read, or has another size.
pub fn read_mask(file: &Path, size: Size) -> Result<Vec<bool>> {
    let picture = match extension(file).as_str() {
        "exr" => every_channel(Layers::read(file)?),
        "pfm" => read_pfm(file)?,
        _ => decode(file)?,
    };
    if picture.size() != size {
        let message = format!("--mask {}: expected {size} pixels as in the reference", file.display());
        return Err(usage(format!("{message}, found {}", picture.size())));
    }
    let kept = |pixel: usize| picture.channels().iter().any(|channel| channel[pixel] != 0.0);
    Ok((0..size.pixels()).map(kept).collect())
}

/// A mask may have any names, and one channel as well as three.
fn every_channel(mut layers: Layers) -> Image {
    let names: Vec<String> = layers.channels.iter().map(|channel| channel.name.clone()).collect();
    let is_alpha = |name: &&String| name.rsplit('.').next() == Some("A");
    let planes = names.iter().filter(|name| !is_alpha(name)).filter_map(|name| layers.take(name)).collect();
    Image::from_channels(layers.window.size, planes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::file::write_picture;

    const SIZE: Size = Size::new(3, 2);

    #[test]
    fn black_is_left_out_in_every_format() {
        let folder = tempfile::tempdir().unwrap();
        let planes = [[0.0, 1.0, 0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0, 0.0, 1.0], [0.0; 6]];
        let picture = Image::from_channels(SIZE, planes.map(|plane| plane.to_vec()).to_vec());
        for name in ["a.exr", "a.pfm", "a.png"] {
            let file = folder.path().join(name);
            match name {
                "a.png" => crate::output::write_png(&file, &picture, 0.0).unwrap(),
                _ => write_picture(&file, &picture).unwrap(),
            }
            assert_eq!(read_mask(&file, SIZE).unwrap(), [false, true, false, true, false, true], "{name}");
            let error = read_mask(&file, Size::new(2, 3)).unwrap_err().to_string();
            assert!(error.contains("2x3") && error.contains("3x2"), "{error}");
        }
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.png");
        std::fs::write(&file, "no picture").unwrap();
        assert!(read_mask(&file, SIZE).unwrap_err().to_string().contains("a.png"));
        assert!(read_mask(&folder.path().join("b.png"), SIZE).is_err());
    }
}
