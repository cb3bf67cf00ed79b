//! Reading files that hold text, however it is encoded.

use std::io::ErrorKind;
use std::path::Path;

use super::SceneError;

/// The bytes of a file.
pub(super) fn read_bytes(path: &Path) -> Result<Vec<u8>, SceneError> {
    let path_buf = path.to_path_buf();
    if path.is_dir() {
        return Err(SceneError::IsFolder { path: path_buf });
    }
    std::fs::read(path).map_err(|source| match source.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory => SceneError::Missing { path: path_buf },
        _ => SceneError::Unreadable { path: path_buf, source },
    })
}

/// The text of a file: UTF-8, or UTF-16 with a byte order mark; bytes that are neither become '\u{fffd}'.
pub(super) fn read_text(path: &Path) -> Result<String, SceneError> {
    Ok(decode(read_bytes(path)?))
}

fn decode(bytes: Vec<u8>) -> String {
    match bytes.as_slice() {
        [0xff, 0xfe, rest @ ..] => decode_utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => decode_utf16(rest, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest).into_owned(),
        _ => String::from_utf8(bytes).unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned()),
    }
}

fn decode_utf16(bytes: &[u8], unit: impl Fn([u8; 2]) -> u16) -> String {
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

/// Logical lines of an OBJ or MTL file with the number of their first physical line: a backslash at the end joins the
/// next line, unless it ends a comment; lines of comments alone and blank ones are left out.
pub(super) fn logical_lines(text: &str) -> impl Iterator<Item = (usize, std::borrow::Cow<'_, str>)> {
    // Old Macs end lines with a lone carriage return, which `lines` would not see.
    let mut physical = text.split('\n').flat_map(|l| l.strip_suffix('\r').unwrap_or(l).split('\r')).zip(1..);
    std::iter::from_fn(move || {
        let (first, number) = physical.next()?;
        let mut line = std::borrow::Cow::Borrowed(first);
        while let Some(start) = line.trim_end().strip_suffix('\\').filter(|start| without_comment(start) == *start) {
            let start = start.to_owned();
            let Some((next, _)) = physical.next() else {
                line = start.into();
                break;
            };
            line = (start + " " + next).into();
        }
        Some((number, line))
    })
    .filter(|(_, line)| !matches!(line.trim_start().chars().next(), None | Some('#')))
}

/// A line without its comment, which begins at the start of a word: `1.#INF` has none.
pub(super) fn without_comment(line: &str) -> &str {
    let starts = line.match_indices('#').map(|(at, _)| at);
    let comment = starts.into_iter().find(|&at| line[..at].ends_with(char::is_whitespace) || at == 0);
    &line[..comment.unwrap_or(line.len())]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_are_told_apart() {
        assert_eq!(decode(b"v 1\n".to_vec()), "v 1\n");
        assert_eq!(decode(b"\xef\xbb\xbfv 1".to_vec()), "v 1");
        assert_eq!(decode(b"\xff\xfev\x00 \x001\x00".to_vec()), "v 1");
        assert_eq!(decode(b"\xfe\xff\x00v\x00 \x001".to_vec()), "v 1");
        assert_eq!(decode(b"caf\xe9".to_vec()), "caf\u{fffd}");
    }

    #[test]
    fn continued_lines_are_joined_and_keep_their_number() {
        let lines: Vec<_> = logical_lines("# a \\\nv 1 \\\r\n 2 3\n\n f 1\rg 2\nend \\").collect();
        let lines: Vec<_> =
            lines.iter().map(|(n, l)| (*n, l.split_whitespace().collect::<Vec<_>>().join(" "))).collect();
        assert_eq!(lines, [(2, "v 1 2 3".into()), (5, "f 1".into()), (6, "g 2".into()), (7, "end".into())]);
        let numbers = |text| logical_lines(text).map(|(number, _)| number).collect::<Vec<_>>();
        assert_eq!(numbers("v 1 # C:\\\nv 2\nv a#\\\nv 3\nv 4"), [1, 2, 3, 5], "a comment is not continued");
    }
}
