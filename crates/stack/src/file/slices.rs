//! Reads renders of ours, and adds up those that hold different samples of one picture.

use std::path::{Path, PathBuf};

use super::own::{found_in, header_of, is_own, read_own};
use super::sources::Open;
use super::taken::{Taken, read_taken};
use super::{Carried, FileError, Layers, ReadStack, StackHeader};
use crate::merge::{Held, MergeError, Record, Slice, Sum, check_records};

/// Reads a render of ours that says which samples it holds, and its record.
///
/// # Errors
/// When it cannot be read, or is something else.
pub fn read_render(path: &Path) -> Result<(ReadStack, Record), FileError> {
    let (layers, header, record) = checked(read_taken(path, Taken::InputsBut(&[]))?)?;
    Ok((read_own(layers, header)?, record))
}

/// What the header of a render says about it.
fn checked(layers: Layers) -> Result<(Layers, StackHeader, Record), FileError> {
    let path = || layers.path.clone();
    let header = header_of(&layers)?.ok_or_else(|| MergeError::NotOurs { path: path() })?;
    if !is_own(&layers) {
        return Err(MergeError::NoInputs { path: path() }.into());
    }
    let record = header.record.clone().ok_or_else(|| MergeError::NoRecord { path: path() })?;
    Ok((layers, header, record))
}

/// Reads slices, whatever their order, one at a time, once all headers have shown that they belong together.
///
/// # Errors
/// When one cannot be read or does not fit the others.
pub(super) fn read_slices(paths: &[PathBuf], open: Open<'_>) -> Result<ReadStack, FileError> {
    let mut slices = Vec::new();
    for path in paths {
        let (_, _, record) = checked(Layers::outline(path)?.0)?;
        slices.push((path.clone(), record));
    }
    // Sums are rounded, so their order must not be that of the arguments.
    slices.sort_by(|a, b| a.1.held.cmp(&b.1.held));
    check_records(&slices)?;
    let mut sum: Option<(Sum, Carried)> = None;
    for (path, _) in slices {
        let (layers, header, _) = checked(open(&path, Taken::InputsBut(&[]))?)?;
        let read = read_own(layers, header.clone())?;
        let slice = Slice { path, stack: read.stack, header };
        match &mut sum {
            Some((sum, _)) => sum.add(slice)?,
            None => sum = Some((Sum::new(slice)?, read.carried)),
        }
    }
    let Some((sum, carried)) = sum else { return Err(FileError::Unclear { reason: "no file given".into() }) };
    let (stack, header) = sum.finish();
    let mut found = found_in(&stack, false);
    if paths.len() > 1 {
        found.remarks.push(format!("{} files add up to {}", paths.len(), in_words(header.record.as_ref())));
    }
    Ok(ReadStack { stack, header: Some(header), notes: found.lines(), found, carried })
}

fn in_words(record: Option<&Record>) -> String {
    let range = |held: &Held| format!("samples {}..{} of seed {}", held.first, held.end, held.seed);
    let ranges: Vec<String> = record.iter().flat_map(|record| &record.held).map(range).collect();
    ranges.join(", ")
}
