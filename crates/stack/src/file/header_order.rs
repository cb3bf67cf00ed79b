//! Custom attributes in a fixed order.
//!
//! The `exr` crate keeps them in a hash map and writes them in an order that differs from run to run, but equal runs must
//! write equal bytes. Their order has no meaning, and to change it changes no length, so the header of a finished file
//! is put in order where it stands.

use std::collections::BTreeSet;
use std::io::{Read, Seek, SeekFrom, Write};
use std::ops::Range;

use super::exr_text::decoded;

/// Names of attributes that are written in random order.
pub type CustomNames = BTreeSet<String>;

/// Bytes before the first attribute: magic number and version.
const PREAMBLE: usize = 8;

/// Bytes read at first; most headers are shorter.
const FIRST_READ: u64 = 1 << 14;

/// Sorts the attributes called `names` in the header of the one-part EXR file that begins at the start of `file`.
///
/// # Errors
/// When `file` cannot be read or written, or does not begin with a whole header.
pub fn sort_attributes(file: &mut (impl Read + Write + Seek), names: &CustomNames) -> std::io::Result<()> {
    if names.len() < 2 {
        return Ok(());
    }
    let mut wanted = FIRST_READ;
    let (bytes, entries) = loop {
        file.seek(SeekFrom::Start(0))?;
        let mut bytes = Vec::new();
        Read::by_ref(file).take(wanted).read_to_end(&mut bytes)?;
        match attributes(&bytes) {
            Some(entries) => break (bytes, entries),
            None if (bytes.len() as u64) < wanted => return Err(std::io::ErrorKind::InvalidData.into()),
            None => wanted *= 4,
        }
    };
    let Some((from, to)) = entries.first().zip(entries.last()).map(|(a, b)| (a.0.start, b.0.end)) else {
        return Ok(());
    };
    file.seek(SeekFrom::Start(from as u64))?;
    file.write_all(&sorted(&bytes[..to], &entries, names))
}

/// All attributes, those called `names` sorted among the places they have together.
fn sorted(bytes: &[u8], entries: &[(Range<usize>, String)], names: &CustomNames) -> Vec<u8> {
    let mut custom: Vec<&(Range<usize>, String)> = entries.iter().filter(|(_, name)| names.contains(name)).collect();
    custom.sort_by(|a, b| a.1.cmp(&b.1));
    let mut custom = custom.into_iter();
    let ordered =
        entries.iter().map(|entry| if names.contains(&entry.1) { custom.next().unwrap_or(entry) } else { entry });
    ordered.flat_map(|(range, _)| bytes[range.clone()].iter().copied()).collect()
}

/// Where each attribute of the first header stands, with its name; `None` when the header does not end within `bytes`.
fn attributes(bytes: &[u8]) -> Option<Vec<(Range<usize>, String)>> {
    let word = |from: usize| {
        let length = bytes.get(from..)?.iter().position(|b| *b == 0)?;
        Some((decoded(&bytes[from..from + length]), from + length + 1))
    };
    let mut entries = Vec::new();
    let mut at = PREAMBLE;
    while *bytes.get(at)? != 0 {
        let (name, after_name) = word(at)?;
        let (_, after_kind) = word(after_name)?;
        let size = u32::from_le_bytes(bytes.get(after_kind..after_kind + 4)?.try_into().ok()?);
        let end = (after_kind + 4).checked_add(size as usize).filter(|end| *end <= bytes.len())?;
        entries.push((at..end, name));
        at = end;
    }
    Some(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn attribute(name: &str, value: &[u8]) -> Vec<u8> {
        let mut bytes = format!("{name}\0string\0").into_bytes();
        bytes.extend((value.len() as u32).to_le_bytes());
        bytes.extend(value);
        bytes
    }

    #[test]
    fn custom_attributes_are_sorted_and_the_rest_stays() {
        let long = vec![7; 40_000];
        let file = |order: [(&str, &[u8]); 4]| {
            let mut bytes = vec![1; PREAMBLE];
            order.iter().for_each(|(name, value)| bytes.extend(attribute(name, value)));
            bytes.extend([0, 9, 9, 9]);
            bytes
        };
        let names: CustomNames = ["b", "a", "c"].map(String::from).into();
        let mut mixed = std::io::Cursor::new(file([("b", b"2"), ("zip", b"!"), ("c", &long), ("a", b"11")]));
        sort_attributes(&mut mixed, &names).unwrap();
        assert_eq!(mixed.into_inner(), file([("a", b"11"), ("zip", b"!"), ("b", b"2"), ("c", &long)]));
    }
}
