//! Reads feature stacks: our own, and other renderers'.

use std::path::{Path, PathBuf};

use super::found::Found;
use super::loaded::{Loaded, ReadOptions, load};
use super::own::{header_of, is_own, load_own, read_own};
use super::same_window::check_window;
use super::slices::read_slices;
use super::sources::{Open, Source, read_sources};
use super::taken::{Taken, read_taken};
use super::together::{alone, several};
use super::{Carried, FileError, StackHeader};
use crate::FeatureStack;
use crate::merge::{Record, check_apart};

/// A stack as it was read.
#[derive(Clone, Debug)]
pub struct ReadStack {
    /// The stack.
    pub stack: FeatureStack,
    /// What our own files say about themselves.
    pub header: Option<StackHeader>,
    /// What was found and how it was understood, a line each.
    pub notes: Vec<String>,
    /// The same, to be looked up.
    pub found: Found,
    /// What the file says beside its pixels.
    pub carried: Carried,
}

/// The files a stack is in.
#[derive(Clone, Debug)]
pub enum Inputs {
    /// One stack: a file with layers, or several whose names say what they are.
    Files(Vec<Source>),
    /// Two renders of equal standing, and perhaps files with features that these lack.
    Halves([PathBuf; 2], Vec<Source>),
    /// Two or more independent renders.
    Buckets(Vec<PathBuf>),
    /// Renders of ours that hold different samples of one picture.
    Slices(Vec<PathBuf>),
}

/// Reads the stack in `inputs`.
///
/// # Errors
/// When a file cannot be read, has no colour, does not fit the others, or leaves open what is what.
pub fn read_inputs(inputs: &Inputs, options: &ReadOptions) -> Result<ReadStack, FileError> {
    read_inputs_by(inputs, options, &mut read_taken)
}

/// As [`read_inputs`], with files read by `open`.
pub(super) fn read_inputs_by(inputs: &Inputs, options: &ReadOptions, open: Open<'_>) -> Result<ReadStack, FileError> {
    check_counts(inputs, options)?;
    match inputs {
        Inputs::Files(files) => read_files(files, options, open),
        Inputs::Halves(halves, features) => read_halves(halves, features, options, open),
        Inputs::Buckets(paths) => {
            if paths.len() < 2 {
                return Err(FileError::TooFewBuckets { found: paths.len() });
            }
            several(load_renders(paths, options, open)?, paths, &options.spp, false)
        }
        Inputs::Slices(paths) => read_slices(paths, open),
    }
}

fn check_counts(inputs: &Inputs, options: &ReadOptions) -> Result<(), FileError> {
    let (renders, name) = match inputs {
        Inputs::Files(_) | Inputs::Slices(_) => (1, "one render".to_string()),
        Inputs::Halves(..) => (2, "two halves".to_string()),
        Inputs::Buckets(paths) => (paths.len(), format!("{} buckets", paths.len())),
    };
    let given = options.spp.len();
    if given > 1 && given != renders { Err(FileError::SampleCounts { given, renders: name }) } else { Ok(()) }
}

/// Reads a stack from one file.
///
/// # Errors
/// When the file cannot be read or holds no colour.
pub fn read_stack(path: &Path) -> Result<ReadStack, FileError> {
    read_inputs(&Inputs::Files(vec![Source::from(path)]), &ReadOptions::default())
}

/// Reads independent renders of one picture, each with its own colour and features, as the buckets of one stack.
///
/// # Errors
/// When there are fewer than two, one cannot be read, sizes or features differ, or two hold the same noise.
pub fn read_buckets(paths: &[PathBuf]) -> Result<ReadStack, FileError> {
    read_inputs(&Inputs::Buckets(paths.to_vec()), &ReadOptions::default())
}

fn read_files(files: &[Source], options: &ReadOptions, open: Open<'_>) -> Result<ReadStack, FileError> {
    let (layers, said) = read_sources(files, Taken::InputsBut(&options.leave_out), open)?;
    match header_of(&layers)? {
        Some(header) if is_own(&layers) => {
            let spp = Some("--spp").filter(|_| !options.spp.is_empty());
            says_itself(&layers.path, spp.or_else(|| said_of(options)))?;
            read_own(layers, header)
        }
        _ => {
            let map = said.into_iter().chain(options.map.iter().cloned()).collect();
            Ok(alone(load(layers, &ReadOptions { map, ..options.clone() }, 0, false)?))
        }
    }
}

/// The flag that says what the layers of a file are.
fn said_of(options: &ReadOptions) -> Option<&'static str> {
    let map = (!options.map.is_empty()).then_some("--map");
    map.or_else(|| options.variance_is.map(|_| "--variance-is"))
}

/// Refuses a `flag` about a file of ours.
fn says_itself(path: &Path, flag: Option<&'static str>) -> Result<(), FileError> {
    flag.map_or(Ok(()), |flag| Err(FileError::SaysItself { path: path.into(), flag }))
}

fn load_renders(paths: &[PathBuf], options: &ReadOptions, open: Open<'_>) -> Result<Vec<Loaded>, FileError> {
    let mut renders: Vec<Loaded> = Vec::new();
    let mut records: Vec<(&Path, Record)> = Vec::new();
    for (nth, path) in paths.iter().enumerate() {
        let layers = open(path, Taken::Means)?;
        let mut render = if is_own(&layers) {
            says_itself(&layers.path, said_of(options))?;
            let header = header_of(&layers)?;
            let samples_unknown = header.as_ref().is_some_and(|header| header.samples_unknown);
            if let Some(record) = header.and_then(|header| header.record) {
                records.iter().try_for_each(|(like, other)| check_apart((path, &record), (like, other)))?;
                records.push((path, record));
            }
            load_own(layers, samples_unknown)
        } else {
            load(layers, options, nth, true)?
        };
        for before in &renders {
            let [now, before] = [&render.rest, &before.rest].map(|layers| (&*layers.path, layers.window));
            check_window(now, before)?;
        }
        if !renders.is_empty() {
            // Only the first one's are carried along: the others' would take as much memory again.
            render.rest.channels = Vec::new();
        }
        renders.push(render);
    }
    Ok(renders)
}

/// Two renders as halves. What only `features` has is taken from there.
fn read_halves(
    halves: &[PathBuf; 2],
    features: &[Source],
    options: &ReadOptions,
    open: Open<'_>,
) -> Result<ReadStack, FileError> {
    let renders = load_renders(halves, options, open)?;
    let window = renders[0].rest.window;
    let mut read = several(renders, halves, &options.spp, true)?;
    if features.is_empty() {
        return Ok(read);
    }
    let mut more = read_files(features, &ReadOptions { spp: Vec::new(), ..options.clone() }, open)?;
    check_window((&features[0].path, more.stack.window), (&halves[0], window))?;
    more.stack.features.retain(|feature| read.stack.feature(feature.role).is_none());
    for feature in &more.stack.features {
        let found = more.found.roles.iter().find(|found| found.role == feature.role.layer());
        read.found.roles.extend(found.cloned());
        read.found.without.retain(|missing| missing != feature.role.layer());
    }
    read.stack.features.append(&mut more.stack.features);
    let place = |role| crate::FeatureRole::ALL.iter().position(|r| *r == role);
    read.stack.features.sort_by_key(|feature| place(feature.role));
    read.notes = read.found.lines();
    Ok(read)
}
