//! Which files make a stack, and what each of them is.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use super::recognise::Mapping;
use super::role::{Measure, Role, Slot};
use super::same_window::check_window;
use super::slot_names::slot_of;
use super::taken::Taken;
use super::{FileError, Layers};

/// A file that is read, and what it is when the user says so.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The file.
    pub path: PathBuf,
    /// What it holds; by its name when not said.
    pub slot: Option<Slot>,
}

impl Source {
    /// Reads `FILE` or `ROLE=FILE`. A file whose whole name is `text` comes first.
    pub fn parse(text: &str) -> Self {
        let said = text.split_once('=').filter(|_| !Path::new(text).exists());
        match said.and_then(|(role, file)| Some((role.parse::<Slot>().ok()?, file))) {
            Some((slot, file)) => Self { path: file.into(), slot: Some(slot) },
            None => Self { path: text.into(), slot: None },
        }
    }
}

impl From<&Path> for Source {
    fn from(path: &Path) -> Self {
        Self { path: path.into(), slot: None }
    }
}

/// What a file is among others.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Part {
    /// One slot, because the user or its name says so.
    Slot(Slot, String),
    /// Something that is known to have no role here, or whose name is not known.
    Other(String),
    /// The picture itself, with its own layers.
    Main,
}

/// Whether `sources` are the files of one stack, each with a role of its own, rather than several stacks.
pub fn is_one_stack(sources: &[Source]) -> bool {
    sources.len() == 1 || parts(sources).is_ok()
}

/// What reads a file.
pub type Open<'a> = &'a mut dyn FnMut(&Path, Taken<'_>) -> Result<Layers, FileError>;

/// Reads `sources` as one file, with what the user says about their roles; of a single one no more than is `taken`.
///
/// # Errors
/// When a file cannot be read, sizes differ, or it is not clear what the files are.
pub fn read_sources(sources: &[Source], taken: Taken<'_>, open: Open<'_>) -> Result<(Layers, Vec<Mapping>), FileError> {
    if let [Source { path, slot: None }] = sources {
        return Ok((open(path, taken)?, Vec::new()));
    }
    let parts = parts(sources)?;
    let mut files: Vec<(&Source, &Part)> = sources.iter().zip(&parts).collect();
    // What the picture's file says beside its pixels is what is kept.
    files.sort_by_key(|(_, part)| match part {
        Part::Main => 0,
        Part::Slot(Slot { role: Role::Colour, measure: Measure::Mean }, _) => 1,
        _ => 2,
    });
    let mut whole: Option<Layers> = None;
    let mut mappings = Vec::new();
    for (source, part) in files {
        let mut layers = open(&source.path, Taken::Everything)?;
        let prefix = match part {
            Part::Main => None,
            Part::Slot(slot, name) => {
                mappings.extend(source.slot.map(|_| (*slot, name.clone())));
                Some(name)
            }
            Part::Other(name) => Some(name),
        };
        if let Some(prefix) = prefix {
            layers.channels.iter_mut().for_each(|channel| channel.name = format!("{prefix}.{}", channel.name));
        }
        match &mut whole {
            None => whole = Some(layers),
            Some(whole) => append(whole, layers)?,
        }
    }
    let mut whole = whole.ok_or_else(|| unclear("no file given".into()))?;
    whole.metadata = None;
    Ok((whole, mappings))
}

fn append(whole: &mut Layers, layers: Layers) -> Result<(), FileError> {
    check_window((&layers.path, layers.window), (&whole.path, whole.window))?;
    let names: HashSet<String> = whole.channels.iter().map(|channel| channel.name.clone()).collect();
    if let Some(twice) = layers.channels.iter().find(|channel| names.contains(&channel.name)) {
        let file = layers.path.display();
        return Err(unclear(format!("{file}: its channel {} is in another file, too", twice.name)));
    }
    whole.channels.extend(layers.channels);
    Ok(())
}

/// What each of several files is.
fn parts(sources: &[Source]) -> Result<Vec<Part>, FileError> {
    let mut parts: Vec<Part> = sources.iter().map(part).collect();
    for (i, part) in parts.iter().enumerate() {
        let Part::Slot(slot, _) = part else { continue };
        let same = |other: &Part| matches!(other, Part::Slot(s, _) if s.same_as(*slot));
        if let Some(j) = parts[..i].iter().position(same) {
            let [a, b] = [j, i].map(|i| sources[i].path.display());
            return Err(unclear(format!("{a} and {b} both look like {slot}")));
        }
    }
    let colour = |part: &Part| matches!(part, Part::Slot(Slot { role: Role::Colour, measure: Measure::Mean }, _));
    let features = parts.iter().any(|part| matches!(part, Part::Slot(..)) && !colour(part));
    if !features {
        return Err(unclear("several files, and no name says albedo, normal, variance or the like".into()));
    }
    if !parts.iter().any(colour) {
        let unknown: Vec<usize> =
            (0..parts.len()).filter(|i| matches!(parts[*i], Part::Other(_)) && !is_known_other(&sources[*i])).collect();
        match unknown[..] {
            [only] => parts[only] = Part::Main,
            _ if parts.iter().all(is_half) => {
                return Err(unclear(
                    "these are halves without their mean: give them with --half-a and --half-b".into(),
                ));
            }
            _ => return Err(unclear("several files, and no name says which of them is the colour".into())),
        }
    }
    Ok(parts)
}

fn is_half(part: &Part) -> bool {
    matches!(part, Part::Slot(Slot { measure: Measure::HalfA | Measure::HalfB, .. }, _))
}

fn part(source: &Source) -> Part {
    if let Some(slot) = source.slot {
        return Part::Slot(slot, slot.to_string());
    }
    match tail(&source.path) {
        Some((name, Some(slot))) => Part::Slot(slot, name),
        Some((name, None)) => Part::Other(name),
        None => Part::Other(stem(&source.path)),
    }
}

fn is_known_other(source: &Source) -> bool {
    tail(&source.path).is_some()
}

fn stem(path: &Path) -> String {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The end of a file's name that says what it is (`scene_ALBEDO_0001.exr`: `ALBEDO`), and what that is.
fn tail(path: &Path) -> Option<(String, Option<Slot>)> {
    let stem = stem(path);
    let name = stem.trim_end_matches(|c: char| c.is_ascii_digit() || "._- #".contains(c));
    let starts = std::iter::once(0).chain(name.match_indices(['.', '_', '-', ' ']).map(|(at, _)| at + 1));
    starts.into_iter().find_map(|start| Some((name[start..].to_string(), slot_of(&name[start..])?)))
}

fn unclear(reason: String) -> FileError {
    FileError::Unclear { reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sources(names: &[&str]) -> Vec<Source> {
        names.iter().map(|name| Source::parse(name)).collect()
    }

    fn slots(names: &[&str]) -> Vec<String> {
        let name = |part: Part| match part {
            Part::Slot(slot, _) => slot.to_string(),
            Part::Other(_) => "-".into(),
            Part::Main => "main".into(),
        };
        parts(&sources(names)).unwrap().into_iter().map(name).collect()
    }

    #[test]
    fn names_say_what_files_are() {
        let luxcore =
            ["RGB_IMAGEPIPELINE_0.exr", "ALBEDO.exr", "AVG_SHADING_NORMAL.exr", "NOISE.exr", "SAMPLECOUNT.exr"];
        assert_eq!(slots(&luxcore), ["colour", "albedo", "normal", "-", "samples"]);
        let tungsten = ["t/color.exr", "t/colorA.exr", "t/colorB.exr", "t/albedoVariance.exr"];
        assert_eq!(slots(&tungsten), ["colour", "colour-a", "colour-b", "albedo-variance"]);
        assert_eq!(slots(&["box.exr", "box_hist.exr", "box_cov.exr"]), ["main", "samples", "colour-variance"]);
        assert_eq!(slots(&["a.hdr.pfm", "a.alb.pfm", "a.nrm.pfm"]), ["colour", "albedo", "normal"]);
        assert_eq!(slots(&["x.exr", "albedo=y.exr", "normal-b=z.exr"]), ["main", "albedo", "normal-b"]);
    }

    #[test]
    fn several_pictures_are_no_stack() {
        for several in [&["shot_0001.exr", "shot_0002.exr"][..], &["beauty1.exr", "beauty2.exr"], &["a.exr", "b.exr"]] {
            assert!(!is_one_stack(&sources(several)), "{several:?}");
        }
        assert!(is_one_stack(&sources(&["color.exr", "albedo.exr"])));
        let error = parts(&sources(&["colorA.exr", "colorB.exr"])).unwrap_err().to_string();
        assert!(error.contains("--half-a"), "{error}");
        let error = parts(&sources(&["color.exr", "albedo.exr", "x_albedo.exr"])).unwrap_err().to_string();
        assert!(error.contains("x_albedo.exr") && error.contains("role=FILE"), "{error}");
    }
}
