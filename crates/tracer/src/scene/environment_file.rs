//! Reading maps of the sky.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder};
use stack::file::{extension, read_picture};

use super::SceneError;
use super::picture_file::{decode, linear_rgb};
use crate::environment::{Environment, EnvironmentMap};

/// Pixels that one byte of a run-length encoded Radiance file can stand for: 8 bytes make a run of 127.
const MOST_COMPRESSED: u64 = 16;

/// Reads a latitude-longitude map: Radiance HDR, OpenEXR or PFM, or any picture that textures may be; with a sentence on
/// what is wrong with its values, if anything is.
///
/// # Errors
/// When there is no such file, or it cannot be read.
pub fn read_environment(path: &Path) -> Result<(Environment, Option<String>), SceneError> {
    if path.is_dir() {
        return Err(bad(path, "it is a folder"));
    }
    if !path.is_file() {
        return Err(SceneError::Missing { path: path.into() });
    }
    let (size, mut texels) = match extension(path).as_str() {
        "exr" | "pfm" => planar(path)?,
        "hdr" | "pic" => radiance(path).map_err(|reason| bad(path, &reason))?,
        _ => decode(path).map(|image| linear_rgb(&image)).map_err(|reason| bad(path, &reason))?,
    };
    let note = mend(path, &mut texels);
    Ok((Environment::mapped(EnvironmentMap::new(size[0], size[1], texels)), note))
}

/// Width and height.
type Size = [usize; 2];

fn planar(path: &Path) -> Result<(Size, Vec<[f32; 3]>), SceneError> {
    let image = read_picture(path)?;
    let (size, planes) = (image.size(), image.channels());
    Ok(([size.width, size.height], (0..size.pixels()).map(|p| [planes[0][p], planes[1][p], planes[2][p]]).collect()))
}

/// A Radiance file. Headers in the wild are not strict, and pictures may be larger than `image` allows by itself.
fn radiance(path: &Path) -> Result<(Size, Vec<[f32; 3]>), String> {
    let file = File::open(path).map_err(|e| e.to_string())?;
    let bytes = file.metadata().map_err(|e| e.to_string())?.len();
    let decoder = HdrDecoder::new_nonstrict(BufReader::new(file)).map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 || pixels > bytes.saturating_mul(MOST_COMPRESSED) {
        return Err(format!("its header claims {width}x{height} pixels, but it has {bytes} bytes"));
    }
    DynamicImage::from_decoder(decoder).map(|image| linear_rgb(&image)).map_err(|e| e.to_string())
}

fn bad(path: &Path, reason: &str) -> SceneError {
    SceneError::BadPicture { path: path.into(), reason: reason.into() }
}

/// Sets what cannot be radiance to zero. Negative values are common: lossy compression makes them.
fn mend(path: &Path, texels: &mut [[f32; 3]]) -> Option<String> {
    let (mut not_finite, mut negative) = (0, 0);
    for value in texels.iter_mut().flatten().filter(|c| !(c.is_finite() && **c >= 0.0)) {
        if *value < 0.0 && value.is_finite() {
            negative += 1
        } else {
            not_finite += 1
        }
        *value = 0.0;
    }
    let what = match (negative, not_finite) {
        (0, 0) => return None,
        (_, 0) => format!("{negative} negative values"),
        (0, _) => format!("{not_finite} values that are not finite"),
        _ => format!("{negative} negative values and {not_finite} that are not finite"),
    };
    Some(format!("{}: {what} count as 0", path.display()))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use glam::Vec3;
    use stack::Fault;

    use super::*;

    fn read(name: &str, content: &[u8]) -> Result<(Environment, Option<String>), SceneError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        fs::write(&path, content).unwrap();
        read_environment(&path)
    }

    /// Two texels, of radiance 1 and (2, 0.5, 0): mantissa ÷ 256 × 2^(exponent − 128).
    const PIXELS: [u8; 8] = [128, 128, 128, 129, 128, 32, 0, 130];

    #[test]
    fn radiance_files_are_read_whatever_their_header_says_besides() {
        let header =
            "#?RADIANCE\n#?RADIANCE\nGAMMA=1\nPRIMARIES=0 0 0 0 0 0 0 0\nstray\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n";
        let (sky, note) = read("a.hdr", &[header.as_bytes(), &PIXELS].concat()).unwrap();
        assert_eq!((sky.map().unwrap().size(), note), ([2, 1], None));
        assert!((sky.radiance(Vec3::X) - Vec3::ONE).length() < 0.02);
        assert!((sky.radiance(-Vec3::X) - Vec3::new(2.0, 0.5, 0.0)).length() < 0.04);
    }

    #[test]
    fn exr_files_are_read_and_what_is_no_radiance_is_counted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sky.exr");
        let planes = vec![vec![1.0, -0.004], vec![f32::NAN, 3.0], vec![2.0, f32::INFINITY]];
        stack::file::write_picture(&path, &stack::Image::from_channels(stack::Size::new(2, 1), planes)).unwrap();
        let (sky, note) = read_environment(&path).unwrap();
        assert!(note.unwrap().ends_with("1 negative values and 2 that are not finite count as 0"));
        assert_eq!(sky.radiance(Vec3::X), Vec3::new(1.0, 0.0, 2.0));
    }

    #[test]
    fn what_is_no_picture_is_refused_by_name() {
        for (name, content) in [("a.hdr", &b"nothing"[..]), ("a.exr", b"nothing"), ("a.png", b""), ("a.txt", b"x")] {
            let error = read(name, content).unwrap_err();
            assert!(error.to_string().contains(name) && error.fault() == Fault::Input, "{error}");
        }
        let huge = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n";
        assert!(read("a.hdr", huge).unwrap_err().to_string().contains("claims 60000x60000"));
        assert!(matches!(read_environment(Path::new("no/such.exr")), Err(SceneError::Missing { .. })));
        assert!(read_environment(Path::new(".")).unwrap_err().to_string().contains("folder"));
    }

    #[test]
    fn shared_maps_are_read_dwa_included() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes/hdr");
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if ["hdr", "exr"].contains(&extension(&path).as_str()) {
                let (sky, _) = read_environment(&path).unwrap();
                let [width, height] = sky.map().unwrap().size();
                assert!(width == 2 * height && sky.mean().min_element() > 0.0, "{}", path.display());
            }
        }
    }
}
