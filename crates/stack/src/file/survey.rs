//! What a stack will take in memory, told by the headers of its files alone.

use std::path::{Path, PathBuf};

use super::loaded::ReadOptions;
use super::memory::check_fits;
use super::own::{header_of, is_own};
use super::read::read_inputs_by;
use super::taken::outline_taken;
use super::{FileError, Inputs, StackHeader};
use crate::Size;

/// While slices are added up, beside them: counts and weights of eight buckets, in bytes a pixel.
const WEIGHING: usize = 100;

/// What is known of a stack before its pixels are read.
#[derive(Clone, Debug)]
pub struct Survey {
    /// Width and height of its images.
    pub size: Size,
    /// What its planes will take, in bytes, as [`crate::FeatureStack::bytes`] says of it once it is there; without the sample
    /// counts of each bucket where these turn out to differ from pixel to pixel.
    pub bytes: usize,
    /// Those of them that stay until the picture is rebuilt: indirect light, and what nobody here interprets; in a
    /// renderer's files whose layers are told by their values, these, too.
    pub staying_bytes: usize,
    /// The most that is held while it is read, in bytes, which is more where slices are added up: their sum beside the next
    /// of them, and how its samples weigh.
    pub reading_bytes: usize,
    /// Independent parts that its colour comes in.
    pub buckets: usize,
    /// What our own files say about themselves.
    pub header: Option<StackHeader>,
    /// A file of ours among the renders that holds the picture alone, without what it was made of.
    pub without_inputs: Option<PathBuf>,
}

/// Looks at the headers of `inputs`: a stack of the same layers, but of one pixel, is put together as the whole one will
/// be.
///
/// # Errors
/// As [`super::read_inputs`], where headers tell, and when all files together need more memory than is free.
pub fn survey(inputs: &Inputs, options: &ReadOptions) -> Result<Survey, FileError> {
    let mut first = None;
    let mut without_inputs = None;
    let one_pixel = read_inputs_by(inputs, options, &mut |path, taken| {
        let (layers, size) = outline_taken(path, taken)?;
        if is_render(path, inputs) && header_of(&layers)?.is_some() && !is_own(&layers) {
            without_inputs.get_or_insert_with(|| path.to_path_buf());
        }
        first.get_or_insert_with(|| (path.to_path_buf(), size));
        Ok(layers)
    })?;
    let Some((path, size)) = first else { return Err(FileError::Unclear { reason: "no file given".into() }) };
    let (bytes, staying) = (one_pixel.stack.bytes(), one_pixel.stack.staying_bytes());
    let adds_up = matches!(inputs, Inputs::Slices(slices) if slices.len() > 1);
    let reading = if adds_up { 2 * bytes + WEIGHING } else { bytes };
    check_fits(&path, (size.width, size.height), reading)?;
    let of_all = |bytes: usize| bytes.saturating_mul(size.pixels());
    let (bytes, staying_bytes, reading_bytes) = (of_all(bytes), of_all(staying), of_all(reading));
    let buckets = one_pixel.stack.samples.dealing.buckets();
    Ok(Survey { size, bytes, staying_bytes, reading_bytes, buckets, header: one_pixel.header, without_inputs })
}

/// Whether `path` is a whole render among `inputs`, and not a file that only lends a layer.
fn is_render(path: &Path, inputs: &Inputs) -> bool {
    match inputs {
        Inputs::Files(files) => files.len() == 1,
        Inputs::Halves(halves, _) => halves.iter().any(|half| half == path),
        Inputs::Buckets(_) | Inputs::Slices(_) => true,
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::super::test_files::{Files, SIZE, noise, shared};
    use super::*;
    use crate::Image;
    use crate::file::{Source, read_inputs, write_pfm};

    fn files(paths: &[PathBuf]) -> Inputs {
        Inputs::Files(paths.iter().map(|path| Source::from(path.as_path())).collect())
    }

    fn agrees(inputs: &Inputs) {
        let survey = survey(inputs, &ReadOptions::default()).unwrap();
        let stack = read_inputs(inputs, &ReadOptions::default()).unwrap().stack;
        let told = (survey.size, survey.bytes, survey.staying_bytes);
        assert_eq!(told, (stack.size(), stack.bytes(), stack.staying_bytes()));
        assert!(survey.bytes > SIZE.pixels() * 12);
    }

    #[test]
    fn headers_tell_what_the_stack_will_take() {
        let folder = Files::new();
        let names = ["R", "G", "B", "albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z", "depth.Z"];
        let with_light = [&names[..], &["key.R", "key.G", "key.B"]].concat();
        agrees(&files(&[folder.half("half.exr", &with_light, &noise, &[])]));
        agrees(&files(&[folder.parts("parts.exr", &[("beauty", &names), ("crypto00", &["R"])], &[])]));
        let bucket = |b: usize| {
            folder.exr(&format!("b{b}.exr"), &with_light, &|name, pixel| noise(&format!("{b}{name}"), pixel), &[])
        };
        let buckets: Vec<PathBuf> = (0..3).map(bucket).collect();
        agrees(&Inputs::Buckets(buckets.clone()));
        let halves = [buckets[0].clone(), buckets[1].clone()];
        let more = folder.exr("more.exr", &["R", "G", "B", "P.X", "P.Y", "P.Z"], &noise, &[]);
        agrees(&Inputs::Halves(halves, vec![Source::from(more.as_path())]));
        let (colour, albedo) = (folder.path("a.hdr.pfm"), folder.path("a.alb.pfm"));
        for path in [&colour, &albedo] {
            write_pfm(path, &Image::zeros(SIZE, 3)).unwrap();
        }
        agrees(&files(&[colour, albedo]));
    }

    #[test]
    fn layers_that_are_told_by_their_values_take_as_much() {
        let Some(folder) = shared("mitsuba") else { return };
        let file = files(&[folder.join("mi_cornell_256_16spp_aov.exr")]);
        let foreseen = survey(&file, &ReadOptions::default()).unwrap();
        let stack = read_inputs(&file, &ReadOptions::default()).unwrap().stack;
        assert_eq!(foreseen.bytes, stack.bytes());
    }
}
