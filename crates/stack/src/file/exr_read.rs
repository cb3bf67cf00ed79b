//! Reads the channels of an EXR file, block by block.
//!
//! By blocks, and not with the `exr` crate's own image reader: sizes are checked before anything is allocated, and a
//! block that cannot be decoded is an error of the thread that asked for it.

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use exr::block::UncompressedBlock;
use exr::block::chunk::Chunk;
use exr::io::Data;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::{ChannelDescription, Compression, FlatSamples, Text, Vec2, f16};
use rayon::prelude::*;

use super::exr_text::decoded;
use super::in_flight::blocks_at_once;
use super::layers::METADATA;
use super::memory::check_fits;
use super::{Action, Carried, FileError, Layers, Passthrough};
use crate::{Size, Window};

/// Bytes that one byte of a file can stand for: deflate reaches 1032, the other codecs less, but for DWA.
const MOST_COMPRESSED: u128 = 1100;

/// The same of DWA: two deflated bytes for a block of 8 × 8 floats.
const MOST_COMPRESSED_BY_DWA: u128 = MOST_COMPRESSED * 128;

/// Bytes that any file may claim.
const SLACK: u128 = 1 << 20;

/// Channels a file may have; more are a mistake, or malice.
pub(super) const MOST_CHANNELS: usize = 1 << 14;

/// Which channels are read, by their full names. For the others no room is made.
pub type Wanted<'a> = &'a dyn Fn(&str) -> bool;

/// Reads the channels `wanted` of all parts, of the finest level.
///
/// # Errors
/// When the file is absent, damaged, larger than memory, or of a kind that is not supported (deep data, subsampled
/// channels, parts of different size).
pub fn read_exr(path: &Path, wanted: Wanted<'_>) -> Result<Layers, FileError> {
    let file = File::open(path).map_err(|source| FileError::io(path, Action::Read, source))?;
    read_exr_from(path, BufReader::new(file), wanted)
}

/// All that [`read_exr`] could read of `path`, with one black pixel in place of the picture, and the picture's size: from the
/// header alone.
///
/// # Errors
/// As there, where the header tells.
pub fn outline_exr(path: &Path) -> Result<(Layers, Size), FileError> {
    let file = File::open(path).map_err(|source| FileError::io(path, Action::Read, source))?;
    let reader =
        exr::block::read(BufReader::new(file), false).map_err(|error| understand(path, Action::Read, error))?;
    let names = channel_names(path, reader.headers(), &|_| true)?;
    let mut layers = frame(path, reader.headers(), &names)?;
    let size = std::mem::replace(&mut layers.window.size, Size::new(1, 1));
    let parts = reader.headers().iter().zip(&names).map(|(header, names)| planes(header, names, 1)).collect();
    add_channels(&mut layers, names, parts);
    Ok((layers, size))
}

/// As [`read_exr`], from anywhere; `path` is what messages call it.
pub(super) fn read_exr_from(
    path: &Path,
    mut source: impl Read + Seek + Send,
    wanted: Wanted<'_>,
) -> Result<Layers, FileError> {
    let damaged = |error| understand(path, Action::Read, error);
    let length = source.seek(SeekFrom::End(0)).and_then(|length| source.rewind().map(|()| length));
    let length = length.map_err(|source| FileError::io(path, Action::Read, source))?;
    let reader = exr::block::read(source, false).map_err(damaged)?;
    let headers = reader.headers().to_vec();
    let names = channel_names(path, &headers, wanted)?;
    let mut layers = frame(path, &headers, &names)?;
    check_length(path, &headers, length)?;
    let chunks = reader.filter_chunks(false, |_, _, block| block.level == Vec2(0, 0)).map_err(damaged)?;
    let room = |(header, names): (&Header, &Names)| planes(header, names, header.layer_size.area());
    let parts: Vec<Planes> = headers.iter().zip(&names).map(room).collect();
    let meta =
        exr::meta::MetaData { requirements: requirements(&headers, path)?, headers: headers.iter().cloned().collect() };
    let (chunks, seen) = (Mutex::new(Some(chunks.into_iter())), Mutex::new(HashSet::new()));
    let next = || -> Option<Result<Chunk, _>> { locked(&chunks).as_mut()?.next() };
    let put = |chunk: Chunk| {
        let block = UncompressedBlock::decompress_chunk(chunk, &meta, false).map_err(damaged)?;
        let position = block.index.pixel_position;
        if !locked(&seen).insert((block.index.layer, position.x(), position.y())) {
            return Err(broken(path, "a block of pixels is there twice"));
        }
        place(&block, &headers[block.index.layer], &parts[block.index.layer]).map_err(damaged)
    };
    let work = |_| -> Result<(), FileError> {
        let done = std::iter::from_fn(next).try_for_each(|chunk| put(chunk.map_err(damaged)?));
        // Whatever it was: nobody needs what the file still holds.
        *locked(&chunks) = None;
        done
    };
    let workers =
        blocks_at_once(headers.iter().map(largest_block).max().unwrap_or(1)).min(rayon::current_num_threads());
    (0..workers).into_par_iter().with_max_len(1).try_for_each(work)?;
    add_channels(&mut layers, names, parts);
    Ok(layers)
}

/// Bytes of the largest block of a part; a tile may claim to be larger than the picture.
fn largest_block(header: &Header) -> usize {
    header.max_block_byte_size().min(header.layer_size.area().saturating_mul(header.channels.bytes_per_pixel))
}

/// Gives `layers` the channels of all parts that were read.
fn add_channels(layers: &mut Layers, names: Vec<Names>, parts: Vec<Planes>) {
    let read = names.into_iter().flatten().zip(parts.into_iter().flatten());
    layers.channels.extend(read.filter_map(|(name, samples)| {
        let samples = samples?.into_inner().unwrap_or_else(PoisonError::into_inner);
        Some(Passthrough { name: name?, samples })
    }));
}

fn requirements(headers: &[Header], path: &Path) -> Result<exr::meta::Requirements, FileError> {
    exr::meta::MetaData::validate(headers, false).map_err(|error| understand(path, Action::Read, error))
}

/// Refuses a file of `length` bytes that is too short for the pixels its headers claim, before room is made for them.
fn check_length(path: &Path, headers: &[Header], length: u64) -> Result<(), FileError> {
    let most = |header: &Header| match header.compression {
        Compression::DWAA(_) | Compression::DWAB(_) => MOST_COMPRESSED_BY_DWA,
        _ => MOST_COMPRESSED,
    };
    let needs =
        |header: &Header| header.layer_size.area() as u128 * header.channels.bytes_per_pixel as u128 / most(header);
    // Once for the whole file, however many parts it has.
    let slack = SLACK / headers.iter().map(most).max().unwrap_or(MOST_COMPRESSED);
    if headers.iter().map(needs).sum::<u128>() > u128::from(length) + slack {
        return Err(broken(path, "it is too short for the size its header claims"));
    }
    Ok(())
}

/// Everything but the pixels, after checks that nothing will be asked for that cannot be had.
fn frame(path: &Path, headers: &[Header], names: &[Names]) -> Result<Layers, FileError> {
    let first = headers.first().ok_or_else(|| broken(path, "it has no part"))?;
    for header in headers {
        if header.deep {
            return Err(unsupported(path, "deep pixels", "flatten the picture first"));
        }
        if header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
            return Err(unsupported(path, "subsampled channels", "write all channels at full resolution"));
        }
        if (header.layer_size, header.own_attributes.layer_position)
            != (first.layer_size, first.own_attributes.layer_position)
        {
            return Err(unsupported(path, "parts of different size", "give each part as a file of its own"));
        }
    }
    if headers.iter().map(|header| header.channels.list.len()).sum::<usize>() > MOST_CHANNELS {
        return Err(unsupported(path, "more than 16384 channels", "leave out what is not needed"));
    }
    let size = first.layer_size;
    let channels = headers.iter().flat_map(|header| &header.channels.list).zip(names.iter().flatten());
    let bytes =
        channels.filter(|(_, name)| name.is_some()).map(|(channel, _)| channel.sample_type.bytes_per_sample()).sum();
    check_fits(path, (size.width(), size.height()), bytes)?;
    let display = first.shared_attributes.display_window;
    let offset = |data: i32, display: i32| {
        data.checked_sub(display).ok_or_else(|| broken(path, "its windows lie too far apart"))
    };
    let position = first.own_attributes.layer_position;
    let (x, y) = (offset(position.x(), display.position.x())?, offset(position.y(), display.position.y())?);
    let own = headers.iter().map(|header| header.own_attributes.clone());
    let mut carried = Carried::new(first.shared_attributes.clone(), own);
    let metadata = carried.take_text(METADATA).and_then(|text| serde_json::from_str(&text).ok());
    Ok(Layers {
        path: path.into(),
        window: Window { x, y, size: Size::new(size.width(), size.height()) },
        film: Size::new(display.size.width(), display.size.height()),
        channels: Vec::new(),
        metadata,
        carried,
    })
}

/// A channel's name with that of its part in front, where there are several parts and it is not there already (Blender
/// repeats it). Where the parts are of several views (stereo), that of its view is the first, and not the part's last as well
/// (`ViewLayer.Combined-left`): what belongs together begins alike.
fn full_name(header: &Header, headers: &[Header], channel: &Text) -> String {
    let channel = decoded(channel.bytes());
    let several = headers.len() > 1;
    let part = header.own_attributes.layer_name.as_ref().filter(|_| several).map(|name| decoded(name.bytes()));
    let part = part.unwrap_or_default();
    let view = view_of(header).filter(|view| headers.iter().any(|other| view_of(other).as_ref() != Some(view)));
    let part = view.as_ref().map_or(&*part, |view| without_view(&part, view));
    let named = match part {
        "" => channel,
        part if channel.starts_with(&format!("{part}.")) => channel,
        part => format!("{part}.{channel}"),
    };
    view.map_or(named.clone(), |view| format!("{view}.{named}"))
}

/// The view that a part is of, where it says.
fn view_of(header: &Header) -> Option<String> {
    header.own_attributes.view_name.as_ref().map(|name| decoded(name.bytes())).filter(|name| !name.is_empty())
}

/// The name of a part without that of its view at the end.
fn without_view<'a>(part: &'a str, view: &str) -> &'a str {
    match part.strip_suffix(view) {
        Some("") => "",
        Some(rest) if rest.ends_with(['-', '.', '_', ' ']) => &rest[..rest.len() - 1],
        _ => part,
    }
}

/// Full names of a part's channels, where they are wanted.
type Names = Vec<Option<String>>;

/// Samples of a part's channels, where they are wanted. Blocks are put in place by all threads, which hold a channel only while
/// they copy its lines.
type Planes = Vec<Option<Mutex<FlatSamples>>>;

/// Full names of the channels of all parts.
fn channel_names(path: &Path, headers: &[Header], wanted: Wanted<'_>) -> Result<Vec<Names>, FileError> {
    let mut seen = HashSet::new();
    let mut name = |header: &Header, channel: &ChannelDescription| {
        let name = full_name(header, headers, &channel.name);
        if !seen.insert(name.clone()) {
            return Err(broken(path, &format!("channel {name} is there twice")));
        }
        Ok(Some(name).filter(|name| wanted(name)))
    };
    headers.iter().map(|header| header.channels.list.iter().map(|channel| name(header, channel)).collect()).collect()
}

/// Black planes of so many pixels for the channels of a part that have `names`.
fn planes(header: &Header, names: &Names, pixels: usize) -> Planes {
    let plane = |kind| match kind {
        SampleType::F32 => FlatSamples::F32(vec![0.0; pixels]),
        SampleType::F16 => FlatSamples::F16(vec![f16::ZERO; pixels]),
        SampleType::U32 => FlatSamples::U32(vec![0; pixels]),
    };
    let channels = header.channels.list.iter().zip(names);
    channels.map(|(channel, name)| name.as_ref().map(|_| Mutex::new(plane(channel.sample_type)))).collect()
}

/// Copies the lines of a block to where they belong.
fn place(block: &UncompressedBlock, header: &Header, planes: &Planes) -> exr::error::UnitResult {
    let (at, size, width) = (block.index.pixel_position, block.index.pixel_size, header.layer_size.width());
    if at.x() + size.width() > width || at.y() + size.height() > header.layer_size.height() {
        return Err(exr::error::Error::Invalid("a block lies outside the picture".into()));
    }
    let line_bytes = header.channels.bytes_per_pixel * size.width();
    // Of a line, what stands in front of a channel.
    let mut before = 0;
    for (channel, plane) in header.channels.list.iter().zip(planes) {
        if let Some(plane) = plane {
            let mut plane = locked(plane);
            for (line, bytes) in block.data.chunks_exact(line_bytes).enumerate() {
                let start = (at.y() + line) * width + at.x();
                copy_line(&bytes[before..], &mut plane, start..start + size.width())?;
            }
        }
        before += channel.sample_type.bytes_per_sample() * size.width();
    }
    Ok(())
}

/// What a lock guards. A thread that panicked with it ends the reading anyway.
fn locked<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Copies as many samples as `range` has places from the start of `bytes`, which are of this machine's order.
fn copy_line(mut bytes: &[u8], plane: &mut FlatSamples, range: std::ops::Range<usize>) -> exr::error::UnitResult {
    match plane {
        FlatSamples::F32(values) => f32::read_slice_ne(&mut bytes, &mut values[range])?,
        FlatSamples::F16(values) => f16::read_slice_ne(&mut bytes, &mut values[range])?,
        FlatSamples::U32(values) => u32::read_slice_ne(&mut bytes, &mut values[range])?,
    }
    Ok(())
}

fn broken(path: &Path, reason: &str) -> FileError {
    FileError::Damaged { path: path.into(), format: "OpenEXR", reason: reason.into() }
}

fn unsupported(path: &Path, what: &str, remedy: &'static str) -> FileError {
    FileError::Unsupported { path: path.into(), what: what.into(), remedy }
}

/// An error of the `exr` crate that came of `action` as one of ours.
pub(super) fn understand(path: &Path, action: Action, error: exr::error::Error) -> FileError {
    use exr::error::Error;
    match error {
        Error::Io(source) => FileError::io(path, action, source),
        Error::NotSupported(what) if what.contains("deep") => {
            unsupported(path, "deep pixels", "flatten the picture first")
        }
        Error::NotSupported(what) if what.contains("compression") => {
            unsupported(path, "files of this compression", "write it with ZIP, PIZ, PXR24, B44 or DWA compression")
        }
        Error::NotSupported(what) => {
            FileError::Unsupported { path: path.into(), what: what.into_owned(), remedy: "convert the file first" }
        }
        Error::Invalid(reason) if action == Action::Write => {
            FileError::io(path, action, std::io::Error::other(reason.into_owned()))
        }
        Error::Invalid(reason) if reason.contains("identifier") => {
            broken(path, "it begins like none; stacks are OpenEXR, PFM or PHM files")
        }
        Error::Invalid(reason) => broken(path, &reason),
        Error::Aborted => broken(path, "reading stopped"),
    }
}
