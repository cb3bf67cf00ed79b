//! Files that belong together show the same part of the picture.

use std::path::Path;

use super::{FileError, extension};
use crate::Window;

/// Demands that the file `path`, which covers `found`, covers what `like` does. PFM files know their size and no place.
///
/// # Errors
/// When their sizes differ, or their places.
pub fn check_window((path, found): (&Path, Window), (like, expected): (&Path, Window)) -> Result<(), FileError> {
    if found.size != expected.size {
        let (expected, found) = (expected.size, found.size);
        return Err(FileError::SizeDiffers { path: path.into(), like: like.into(), expected, found });
    }
    let has_place = |file: &Path| !["pfm", "phm"].contains(&extension(file).as_str());
    if found != expected && has_place(path) && has_place(like) {
        let (expected, found) = ([expected.x, expected.y], [found.x, found.y]);
        return Err(FileError::PlaceDiffers { path: path.into(), like: like.into(), expected, found });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::test_files::{Files, SIZE, noise, noise_of};
    use super::*;
    use crate::Size;
    use crate::file::{Inputs, Layers, ReadOptions, Source, read_buckets, read_inputs, write_pfm};

    #[test]
    fn crops_from_different_places_are_not_one_picture() {
        let folder = Files::new();
        let bucket = |b: usize, x: i32| {
            let names = ["R", "G", "B", "albedo.R", "albedo.G", "albedo.B"];
            let path =
                folder.exr(&format!("b{b}.exr"), &names, &|name, pixel| noise(&format!("{b}{name}"), pixel), &[]);
            let mut layers = Layers::read(&path).unwrap();
            (layers.window.x, layers.film) = (x, Size::new(40, 30));
            layers.write(&path).unwrap();
            path
        };
        let [a, b, elsewhere] = [bucket(0, 20), bucket(1, 20), bucket(2, 0)];
        read_buckets(&[a.clone(), b.clone()]).unwrap();
        let refused = read_buckets(&[a.clone(), b.clone(), elsewhere.clone()]).unwrap_err().to_string();
        assert!(refused.contains("b2.exr: expected pixels from 20,0 on as in "), "{refused}");
        let read = |inputs: &Inputs| read_inputs(inputs, &ReadOptions::default());
        let role = |text: &str, path: &Path| Source::parse(&format!("{text}={}", path.display()));
        let albedo_elsewhere = Inputs::Halves([a.clone(), b], vec![Source::from(&*elsewhere)]);
        assert!(matches!(read(&albedo_elsewhere), Err(FileError::PlaceDiffers { .. })));
        let files = |albedo: &Path| Inputs::Files(vec![role("colour", &a), role("albedo", albedo)]);
        assert!(matches!(read(&files(&elsewhere)), Err(FileError::PlaceDiffers { .. })));
        let pfm = folder.path("albedo.pfm");
        write_pfm(&pfm, &noise_of(&["r", "g", "b"])).unwrap();
        assert_eq!(read(&files(&pfm)).unwrap().stack.size(), SIZE, "a PFM file may be anywhere");
    }
}
