//! An OBJ file as tobj can read it.

use std::collections::BTreeSet;
use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};

use super::super::error::Place;
use super::super::mtl::MtlLibrary;
use super::super::notes::Notes;
use super::super::source::logical_lines;
use super::SceneError;

/// Feeds tobj one mended line after the other.
///
/// - Continued lines are joined; comments, groups, points and lines are left out, and so is `usemtl` without a name.
/// - `nan`, `1.#INF` and their like become NaN, so that their triangles can be dropped; `vt` with one number gets two.
/// - Faces are checked: every index must be a whole number other than zero and point to something. tobj would wrap
///   some, and reports the others without a line.
/// - Colours of vertices are left out.
/// - Indices of texture coordinates and of normals are left out where the file has none at all.
/// - Where corners begin to have, or not to have, texture coordinates or normals, a new group is begun: tobj would
///   otherwise misalign them.
pub(super) struct CleanLines<'t> {
    lines: Box<dyn Iterator<Item = (usize, std::borrow::Cow<'t, str>)> + 't>,
    path: PathBuf,
    /// The line being handed out, and how much of it has been.
    current: String,
    given: usize,
    number: usize,
    /// Vertices, texture coordinates, normals so far.
    counts: [usize; 3],
    /// Of each kind, indices greater than all before that pointed ahead when they were used, and the lines where.
    ahead: [Vec<(usize, usize)>; 3],
    format: Option<[bool; 2]>,
    /// Whether the file has any texture coordinates and any normals.
    has: [bool; 2],
    /// Whether faces refer to those that it has none of.
    misses: [bool; 2],
    skipped_faces: usize,
    /// Statements left out that would show something: points, lines, curves and surfaces.
    skipped: [usize; 3],
    materials: BTreeSet<String>,
    fault: Option<SceneError>,
}

const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

impl<'t> CleanLines<'t> {
    /// Cleans `text`, the content of `path`.
    pub(super) fn new(text: &'t str, path: &Path) -> Self {
        Self {
            lines: Box::new(logical_lines(text)),
            path: path.into(),
            current: String::new(),
            given: 0,
            number: 0,
            counts: [0; 3],
            ahead: Default::default(),
            format: None,
            has: ["vt", "vn"].map(|key| text.split(['\n', '\r']).any(|line| line.trim_start().starts_with(key))),
            misses: [false; 2],
            skipped_faces: 0,
            skipped: [0; 3],
            materials: BTreeSet::new(),
            fault: None,
        }
    }

    /// Vertices seen.
    pub(super) fn vertices(&self) -> usize {
        self.counts[0]
    }

    /// Says what was left out, and which materials are missing among `known`.
    pub(super) fn note(&self, known: &MtlLibrary, notes: &mut Notes) {
        for name in self.materials.iter().filter(|name| !known.has(name)) {
            notes.add(format!("{}: no library has material '{name}'; grey is used", self.path.display()));
        }
        for (kind, _) in [1, 2].into_iter().zip(self.misses).filter(|(_, misses)| *misses) {
            let path = self.path.display();
            notes.add(format!("{path}: faces refer to {}s, of which the file has none; they do without", KINDS[kind]));
        }
        let [points, lines, curved] = self.skipped;
        let left_out = [
            (self.skipped_faces, "faces with fewer than three corners"),
            (points, "statements of points"),
            (lines, "statements of lines"),
            (curved, "curves and curved surfaces"),
        ];
        for (count, what) in left_out.into_iter().filter(|(count, _)| *count > 0) {
            notes.add(format!("{}: {count} {what} left out", self.path.display()));
        }
    }

    /// To be called after tobj has read everything, with its error if it gave up.
    ///
    /// # Errors
    /// The first mistake in the file.
    pub(super) fn finish(&mut self, refused: Option<&tobj::LoadError>) -> Result<(), SceneError> {
        if let Some(fault) = self.fault.take() {
            return Err(fault);
        }
        let beyond = |kind: usize| self.ahead[kind].iter().find(|&&(index, _)| index > self.counts[kind]);
        let first = (0..3).filter_map(|kind| Some((kind, *beyond(kind)?))).min_by_key(|(_, (_, line))| *line);
        if let Some((kind, (index, line))) = first {
            return Err(self.out_of_range(kind, index as i64, line));
        }
        refused.map_or(Ok(()), |error| Err(self.malformed(expected_by(error), &self.current)))
    }

    fn out_of_range(&self, kind: usize, index: i64, line: usize) -> SceneError {
        SceneError::Malformed {
            place: Place { file: self.path.clone(), line },
            expected: format!("a {} that exists (there are {})", KINDS[kind], self.counts[kind]),
            found: format!("number {index}"),
        }
    }

    fn malformed(&self, expected: &str, found: &str) -> SceneError {
        let place = Place { file: self.path.clone(), line: self.number };
        let found: String = found.trim().chars().take(60).collect();
        SceneError::Malformed { place, expected: expected.into(), found: format!("'{found}'") }
    }

    /// The next line worth giving to tobj, with its end.
    fn next_line(&mut self) -> Result<Option<String>, SceneError> {
        while let Some((number, line)) = self.lines.next() {
            self.number = number;
            let line = without_comment(&line).trim();
            let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            let rest = rest.trim();
            let cleaned = match key {
                "v" => self.counted(0, format!("v {}\n", without_colour(&mend_numbers(rest)))),
                "vt" if !rest.contains(char::is_whitespace) => {
                    self.counted(1, format!("vt {} 0\n", mend_numbers(rest)))
                }
                "vt" => self.counted(1, format!("vt {}\n", mend_numbers(rest))),
                "vn" => self.counted(2, format!("vn {}\n", mend_numbers(rest))),
                "f" | "fo" => self.face(rest)?,
                "usemtl" if !rest.is_empty() => self.used(rest),
                "mtllib" if !rest.is_empty() => Some(format!("mtllib {rest}\n")),
                "p" => self.skip(0),
                "l" => self.skip(1),
                "curv" | "curv2" | "surf" => self.skip(2),
                _ => None,
            };
            if let Some(cleaned) = cleaned {
                return Ok(Some(cleaned));
            }
        }
        Ok(None)
    }

    fn skip(&mut self, kind: usize) -> Option<String> {
        self.skipped[kind] += 1;
        None
    }

    fn used(&mut self, name: &str) -> Option<String> {
        self.materials.insert(name.into());
        Some(format!("usemtl {name}\n"))
    }

    fn counted(&mut self, kind: usize, line: String) -> Option<String> {
        self.counts[kind] += 1;
        Some(line)
    }

    /// A face, preceded by a new group when its corners know other things than those of the face before.
    fn face(&mut self, corners: &str) -> Result<Option<String>, SceneError> {
        let mut common = [true; 2];
        let mut known = vec![];
        for corner in corners.split_whitespace() {
            let of_corner = self.corner(corner)?;
            common = [common[0] && of_corner[0], common[1] && of_corner[1]];
            known.push((corner, of_corner));
        }
        if known.len() < 3 {
            self.skipped_faces += 1;
            return Ok(None);
        }
        let group = if self.format.is_some_and(|format| format != common) { "g\n" } else { "" };
        self.format = Some(common);
        let corners = known.iter().map(|&(corner, known)| {
            if known == common && self.has == [true; 2] { corner.into() } else { keep(corner, common) }
        });
        Ok(Some(format!("{group}f {}\n", corners.collect::<Vec<String>>().join(" "))))
    }

    /// Checks the indices of a corner; says whether it has texture coordinates and a normal.
    fn corner(&mut self, corner: &str) -> Result<[bool; 2], SceneError> {
        let mut known = [false; 3];
        for (kind, word) in corner.split('/').enumerate() {
            if word.is_empty() && kind > 0 {
                continue;
            }
            let index: i64 = match word.parse() {
                Ok(index) if kind < 3 => index,
                _ => return Err(self.malformed("corners like 1, 1/2, 1//3 or 1/2/3", corner)),
            };
            if kind > 0 && !self.has[kind - 1] {
                self.misses[kind - 1] = true;
                continue;
            }
            let absolute = if index < 0 { self.counts[kind] as i64 + 1 + index } else { index };
            if absolute < 1 {
                return Err(self.out_of_range(kind, index, self.number));
            }
            let greatest =
                self.ahead[kind].last().map_or(self.counts[kind], |&(index, _)| index.max(self.counts[kind]));
            if absolute as usize > greatest {
                self.ahead[kind].push((absolute as usize, self.number));
            }
            known[kind] = true;
        }
        Ok([known[1], known[2]])
    }
}

/// A corner without the texture coordinate or normal that other corners of its face lack.
fn keep(corner: &str, [texture, normal]: [bool; 2]) -> String {
    let word = |kind: usize, keep: bool| if keep { corner.split('/').nth(kind).unwrap_or_default() } else { "" };
    format!("{}/{}/{}", word(0, true), word(1, texture), word(2, normal))
}

/// A line without its comment, which begins at the start of a word: `1.#INF` has none.
fn without_comment(line: &str) -> &str {
    let starts = line.match_indices('#').map(|(at, _)| at);
    let comment = starts.into_iter().find(|&at| line[..at].ends_with(char::is_whitespace) || at == 0);
    &line[..comment.unwrap_or(line.len())]
}

/// What tobj wanted where it gave up.
fn expected_by(error: &tobj::LoadError) -> &'static str {
    match error {
        tobj::LoadError::PositionParseError | tobj::LoadError::ColorParseError => "v and three numbers",
        tobj::LoadError::ScalingByZeroError => "a fourth number other than zero",
        tobj::LoadError::TexcoordParseError => "vt and two numbers",
        tobj::LoadError::NormalParseError => "vn and three numbers",
        _ => "an OBJ statement",
    }
}

/// The numbers of a vertex without its colour, which tobj wants of every vertex or of none.
fn without_colour(numbers: &str) -> String {
    let words: Vec<&str> = numbers.split(' ').collect();
    if words.len() > 4 { words[..3].join(" ") } else { numbers.into() }
}

/// Numbers as Rust reads them: what means NaN or infinity becomes NaN.
fn mend_numbers(numbers: &str) -> String {
    let strange = |word: &str| {
        let bare = word.trim_start_matches(['+', '-']).to_ascii_lowercase();
        bare.starts_with("nan") || bare.starts_with("inf") || bare.contains("#")
    };
    let mended: Vec<&str> = numbers.split_whitespace().map(|word| if strange(word) { "NaN" } else { word }).collect();
    mended.join(" ")
}

impl BufRead for CleanLines<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.given == self.current.len() {
            self.given = 0;
            self.current.clear();
            match self.next_line() {
                Ok(line) => self.current = line.unwrap_or_default(),
                Err(fault) => {
                    self.fault = Some(fault);
                    return Err(io::ErrorKind::InvalidData.into());
                }
            }
        }
        Ok(&self.current.as_bytes()[self.given..])
    }

    fn consume(&mut self, amount: usize) {
        self.given += amount;
    }
}

impl Read for CleanLines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}
