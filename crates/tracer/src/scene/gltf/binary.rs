//! The container of a `.glb` file.

/// The JSON of a glTF file, and the binary part where there is one, whatever the file is called.
///
/// # Errors
/// In words, when it begins like a binary one and is not.
pub(super) fn parts_of(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let Some(rest) = bytes.strip_prefix(b"glTF") else { return Ok((bytes, None)) };
    let (version, rest) = number(rest)?;
    if version != 2 {
        return Err(format!("expected version 2 of the binary format, found {version}"));
    }
    // The length of all: chunks have theirs.
    let (_, rest) = number(rest)?;
    let (json, rest) = chunk(rest, b"JSON")?;
    let binary = if rest.is_empty() { None } else { Some(chunk(rest, b"BIN\0")?.0) };
    Ok((json, binary))
}

/// The content of a chunk of the `kind` expected, and what comes after it.
fn chunk<'a>(bytes: &'a [u8], kind: &[u8; 4]) -> Result<(&'a [u8], &'a [u8]), String> {
    let (length, rest) = number(bytes)?;
    let name = String::from_utf8_lossy(kind.strip_suffix(b"\0").unwrap_or(kind));
    let content = rest.strip_prefix(kind).ok_or_else(|| format!("expected a chunk {name}, found another"))?;
    let count = content.len();
    let content = content.split_at_checked(length as usize);
    content.ok_or_else(|| format!("its chunk {name} claims {length} bytes, but there are {count}"))
}

/// Takes a number off the front.
fn number(bytes: &[u8]) -> Result<(u32, &[u8]), String> {
    let (four, rest) = bytes.split_first_chunk().ok_or("ends within its header")?;
    Ok((u32::from_le_bytes(*four), rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_taken_apart_and_what_is_cut_off_is_said() {
        let all = b"glTF\x02\0\0\0\x99\0\0\0\x04\0\0\0JSON{  }\x04\0\0\0BIN\0abcd";
        assert_eq!(parts_of(all), Ok((b"{  }".as_slice(), Some(b"abcd".as_slice()))));
        assert_eq!(parts_of(&all[..24]), Ok((b"{  }".as_slice(), None)));
        assert_eq!(parts_of(b"{}"), Ok((b"{}".as_slice(), None)));
        let refused = |bytes: &[u8]| parts_of(bytes).unwrap_err();
        assert_eq!(refused(&all[..34]), "its chunk BIN claims 4 bytes, but there are 2");
        assert_eq!(refused(&all[..22]), "its chunk JSON claims 4 bytes, but there are 2");
        assert_eq!(refused(&all[..14]), "ends within its header");
        assert_eq!(refused(b"glTF\x01\0\0\0"), "expected version 2 of the binary format, found 1");
        assert_eq!(refused(b"glTF\x02\0\0\0\0\0\0\0\0\0\0\0BIN\0"), "expected a chunk JSON, found another");
    }
}
