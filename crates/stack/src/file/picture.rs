//! A plain picture: three channels of linear radiance.

use std::path::Path;

use super::borrowed::BorrowedSamples;
use super::recognise::XYZ;
use super::write::SAMPLES;
use super::write_channels::{Frame, write_channels};
use super::xyz::rgb_of_xyz;
use super::{Carried, FileError, Layers, Record, read_pfm, write_pfm};
use crate::{Image, Window};

/// Reads the picture in an EXR file (its `R G B`, the first layer that has them, a grey `Y`, or Mitsuba's
/// `X Y Z`) or a PFM file.
///
/// # Errors
/// When the file cannot be read or holds no colour.
pub fn read_picture(path: &Path) -> Result<Image, FileError> {
    read_picture_with_alpha(path).map(|(picture, _)| picture)
}

/// As [`read_picture`], with the plane `A` that belongs to the picture, if there is one.
///
/// # Errors
/// As [`read_picture`].
pub fn read_picture_with_alpha(path: &Path) -> Result<(Image, Option<Vec<f32>>), FileError> {
    if extension(path) == "pfm" {
        return Ok((read_pfm(path)?, None));
    }
    let mut layers = read_picture_layers(path)?;
    let (picture, prefix) = take_picture(&mut layers)?;
    Ok((picture, layers.take(&format!("{prefix}A"))))
}

/// As [`read_picture`], with what the file says about how the picture was made.
///
/// # Errors
/// As [`read_picture`].
pub fn read_picture_with_record(path: &Path) -> Result<(Image, Record), FileError> {
    if extension(path) == "pfm" {
        return Ok((read_pfm(path)?, Record::default()));
    }
    let mut layers = read_picture_layers(path)?;
    let record = Record::take(&mut layers);
    Ok((take_picture(&mut layers)?.0, record))
}

/// Reads what [`take_picture`] takes, alpha and the counts of samples: of a stack of ours a thirtieth.
pub(super) fn read_picture_layers(path: &Path) -> Result<Layers, FileError> {
    let (outline, _) = Layers::outline(path)?;
    let picture: Vec<String> = match colour_prefix(&outline) {
        Ok(prefix) => ["R", "G", "B", "A"].map(|channel| format!("{prefix}{channel}")).into(),
        Err(_) if is_xyz(&outline) => ["X", "Y", "Z", "A"].map(String::from).into(),
        Err(_) if outline.has("Y") => ["Y", "A"].map(String::from).into(),
        Err(no_colour) => return Err(no_colour),
    };
    let counts = format!("{SAMPLES}.Y");
    Layers::read_some(path, &|name| name == counts || picture.iter().any(|wanted| wanted == name))
}

/// Takes the picture out, and tells what stood in front of its channels' names.
fn take_picture(layers: &mut Layers) -> Result<(Image, String), FileError> {
    let (prefix, planes) = match colour_prefix(layers) {
        Ok(prefix) => {
            let planes = ["R", "G", "B"].iter().filter_map(|c| layers.take(&format!("{prefix}{c}"))).collect();
            (prefix, planes)
        }
        Err(_) if is_xyz(layers) => {
            let planes = XYZ.iter().filter_map(|channel| layers.take(channel)).collect();
            return Ok((rgb_of_xyz(&Image::from_channels(layers.window.size, planes)), String::new()));
        }
        Err(no_colour) => (String::new(), vec![layers.take("Y").ok_or(no_colour)?; 3]),
    };
    Ok((Image::from_channels(layers.window.size, planes), prefix))
}

/// Whether a file without `R G B` holds Mitsuba's picture of CIE XYZ; elsewhere such channels may be a position.
fn is_xyz(layers: &Layers) -> bool {
    XYZ.iter().all(|channel| layers.has(channel)) && layers.carried.begins_with("generatedBy", "Mitsuba")
}

/// What stands in front of `R`, `G` and `B` in the channels that hold the picture.
pub(super) fn colour_prefix(layers: &Layers) -> Result<String, FileError> {
    let complete = |prefix: &str| ["R", "G", "B"].iter().all(|c| layers.has(&format!("{prefix}{c}")));
    let nested = || {
        let reds = layers.channels.iter().filter_map(|channel| channel.name.strip_suffix(".R"));
        let beauty = |layer: &&str| {
            let own = layer.rsplit('.').next().unwrap_or(layer).to_lowercase();
            ["combined", "noisy image", "noisy", "beauty", "rgba"].contains(&own.as_str())
        };
        reds.filter(beauty).map(|layer| format!("{layer}.")).find(|prefix| complete(prefix))
    };
    if complete("") { Some(String::new()) } else { nested() }.ok_or_else(|| FileError::Missing {
        path: layers.path.clone(),
        wanted: "colour",
        expected: "R G B".into(),
        found: layers.names(),
    })
}

/// Writes `image` as an EXR or, by its ending, a PFM file.
///
/// # Errors
/// When the file cannot be written.
pub fn write_picture(path: &Path, image: &Image) -> Result<(), FileError> {
    if extension(path) == "pfm" {
        return write_pfm(path, image);
    }
    let channels = ["R", "G", "B"].iter().zip(image.channels());
    let channels = channels.map(|(name, plane)| ((*name).to_string(), BorrowedSamples::Float(plane))).collect();
    let frame = Frame { window: Window::whole(image.size()), film: image.size(), carried: &Carried::default() };
    write_channels(path, frame, None, channels)
}

/// The file's ending in lower case, without its dot; empty when there is none.
pub fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Size;

    #[test]
    fn grey_is_all_three_colours_and_alpha_comes_along() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let size = Size::new(2, 1);
        let carried = Carried::default();
        let frame = || Frame { window: Window::whole(size), film: size, carried: &carried };
        let write = |names: &[&str]| {
            let plane = |i: usize| [i as f32, 0.5];
            let planes: Vec<[f32; 2]> = (0..names.len()).map(plane).collect();
            let channels = names.iter().zip(&planes).map(|(n, p)| ((*n).to_string(), BorrowedSamples::Float(p)));
            write_channels(&path, frame(), None, channels.collect()).unwrap();
        };
        write(&["A", "Y"]);
        let (grey, alpha) = read_picture_with_alpha(&path).unwrap();
        assert_eq!((grey.channels()[0].clone(), grey.channels()[2].clone()), (vec![1.0, 0.5], vec![1.0, 0.5]));
        assert_eq!(alpha, Some(vec![0.0, 0.5]));
        write(&["Z", "depth"]);
        assert!(read_picture(&path).unwrap_err().to_string().contains("R G B"));
    }

    #[test]
    fn only_files_of_ours_have_settings_and_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let size = Size::new(2, 1);
        let carried = Carried::default();
        let write = |metadata: Option<&serde_json::Value>| {
            let frame = Frame { window: Window::whole(size), film: size, carried: &carried };
            let channels = ["R", "G", "B", "samples.Y"].map(|name| (name.into(), BorrowedSamples::Float(&[2.0, 6.0])));
            write_channels(&path, frame, metadata, channels.to_vec()).unwrap();
            read_picture_with_record(&path).unwrap()
        };
        let settings = serde_json::json!({"trace": {"seed": 3}});
        let header = serde_json::json!({"first": 0, "sequences": 8, "buckets": 8, "settings": settings});
        let (picture, record) = write(Some(&header));
        let spp = record.spp.unwrap();
        assert_eq!((spp.mean, spp.min, spp.max), (4.0, 2, 6));
        assert_eq!((record.settings, record.software.as_deref()), (Some(settings), Some("tamis")));
        assert_eq!(picture, read_picture(&path).unwrap());
        for foreign in [None, Some(&serde_json::json!("another program's"))] {
            let (_, record) = write(foreign);
            assert_eq!((record.settings, record.spp), (None, None));
        }
    }

    #[test]
    fn a_picture_survives_a_round_trip_and_a_cut_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let planes = (0..3).map(|c| (0..12).map(|i| (c * 7 + i) as f32 * 0.3).collect()).collect();
        let image = Image::from_channels(Size::new(4, 3), planes);
        write_picture(&path, &image).unwrap();
        assert_eq!(read_picture_with_alpha(&path).unwrap(), (image, None));
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        assert!(matches!(read_picture(&path), Err(FileError::Damaged { .. })));
        assert!(matches!(read_picture(folder.path()), Err(FileError::Folder { .. })));
        assert!(matches!(read_picture(&folder.path().join("b.exr")), Err(FileError::Io { .. })));
    }
}
