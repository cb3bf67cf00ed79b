//! A piece of an OBJ file, parsed by itself: where the others are and how much they hold need not be known.

use glam::{Vec2, Vec3};

use super::super::source::{logical_lines, without_comment};

/// What a piece holds.
#[derive(Debug, Default)]
pub(super) struct Piece {
    pub(super) positions: Vec<Vec3>,
    /// Colours of the vertices, as written: white where nothing is. Empty where no vertex has one.
    pub(super) colours: Vec<Vec3>,
    pub(super) uvs: Vec<Vec2>,
    pub(super) normals: Vec<Vec3>,
    /// Corners of all faces, by kind: zero-based indices of vertex, texture coordinate and normal; [`NONE`] for what
    /// there is not. The last two are empty when no corner has any.
    pub(super) corners: [Vec<u32>; 3],
    /// Which of the corners' indices count from the piece's first vertex, and may be negative.
    relative: [Vec<u32>; 3],
    /// Corners of each face; empty while all are triangles.
    pub(super) arities: Vec<u32>,
    pub(super) faces: usize,
    /// What comes before the face of that number.
    pub(super) events: Vec<(usize, Event)>,
    /// Faces with fewer than three corners.
    pub(super) skipped_faces: usize,
    /// Statements left out that would show something: points, lines, curves and surfaces.
    pub(super) skipped: [usize; 3],
    /// Whether corners refer to texture coordinates and to normals although the file has none at all.
    pub(super) misses: [bool; 2],
    /// Physical lines.
    pub(super) lines: usize,
    /// What ended the parsing.
    pub(super) mistake: Option<Mistake>,
}

/// What changes how the faces after it look.
#[derive(Debug)]
pub(super) enum Event {
    /// A library, or several, by name; what may be a comment is part of it.
    Library(String),
    /// A material, by name; what may be a comment is part of it.
    Use(String),
}

/// A line that does not read as it should.
#[derive(Debug)]
pub(super) struct Mistake {
    /// The line within the piece, from 1.
    pub(super) line: usize,
    pub(super) expected: String,
    pub(super) found: String,
}

/// An index that points to nothing.
pub(super) const NONE: u32 = u32::MAX;

pub(super) const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// How many vertices, texture coordinates and normals there are.
pub(super) type Counts = [usize; 3];

impl Piece {
    /// Parses a piece that consists of whole lines.
    pub(super) fn parse(text: &str) -> Self {
        let mut piece = Self { lines: physical_lines(text), ..Self::default() };
        for (line, statement) in logical_lines(text) {
            if let Err((expected, found)) = piece.add(&statement) {
                let found: String = found.trim().chars().take(60).collect();
                piece.mistake = Some(Mistake { line, expected: expected.into(), found: format!("'{found}'") });
                break;
            }
        }
        piece
    }

    /// What it adds to the counts.
    pub(super) fn counts(&self) -> Counts {
        [self.positions.len(), self.uvs.len(), self.normals.len()]
    }

    /// Adds a statement. When it does not read as it should, says what was expected and what was found.
    fn add<'s>(&mut self, statement: &'s str) -> Result<(), (&'static str, &'s str)> {
        let (_, name) = split_key(statement.trim());
        let statement = without_comment(statement).trim();
        let (key, rest) = split_key(statement);
        match key {
            "v" => {
                let (position, colour) = vertex(rest).ok_or(("v and three numbers", statement))?;
                self.positions.push(position);
                self.add_colour(colour);
            }
            "vt" => self.uvs.push(uv(rest).ok_or(("vt and two numbers", statement))?),
            "vn" => {
                let normal = numbers(rest).ok_or(("vn and three numbers", statement))?;
                self.normals.push(Vec3::from_array(normal));
            }
            "f" | "fo" => self.add_face(rest)?,
            "usemtl" if !name.is_empty() => self.events.push((self.faces, Event::Use(name.into()))),
            "mtllib" if !name.is_empty() => self.events.push((self.faces, Event::Library(name.into()))),
            "p" => self.skipped[0] += 1,
            "l" => self.skipped[1] += 1,
            "curv" | "curv2" | "surf" => self.skipped[2] += 1,
            _ => {}
        }
        Ok(())
    }

    /// Adds the colour of the last vertex.
    fn add_colour(&mut self, colour: Option<Vec3>) {
        if colour.is_some() || !self.colours.is_empty() {
            self.colours.resize(self.positions.len() - 1, Vec3::ONE);
            self.colours.push(colour.unwrap_or(Vec3::ONE));
        }
    }

    /// Adds a face. What only some of its corners have, it does without.
    fn add_face<'s>(&mut self, face: &'s str) -> Result<(), (&'static str, &'s str)> {
        let first = self.corners[0].len();
        let mut common = [true; 3];
        for word in face.split_ascii_whitespace() {
            let corner = corner(word).ok_or(("corners like 1, 1/2, 1//3 or 1/2/3", word))?;
            for kind in 0..3 {
                common[kind] &= corner[kind].is_some();
                self.push(kind, corner[kind]);
            }
        }
        let arity = self.corners[0].len() - first;
        if arity < 3 {
            (0..3).for_each(|kind| self.truncate(kind, first));
            self.skipped_faces += 1;
            return Ok(());
        }
        for kind in 1..3 {
            if !common[kind] && !self.corners[kind].is_empty() {
                self.truncate(kind, first);
                self.corners[kind].resize(first + arity, NONE);
            }
        }
        if arity != 3 && self.arities.is_empty() {
            self.arities.resize(self.faces, 3);
        }
        if arity != 3 || !self.arities.is_empty() {
            self.arities.push(arity as u32);
        }
        self.faces += 1;
        Ok(())
    }

    /// Adds an index of a corner as written: from one, or below zero from the last so far.
    fn push(&mut self, kind: usize, written: Option<i64>) {
        let at = self.corners[0].len() - usize::from(kind > 0);
        let corners = &mut self.corners[kind];
        let Some(written) = written else {
            if !corners.is_empty() {
                corners.push(NONE);
            }
            return;
        };
        corners.resize(at, NONE);
        if written > 0 {
            // What is greater than any count is out of range, and stays so.
            corners.push(u32::try_from(written - 1).unwrap_or(NONE).min(NONE - 1));
            return;
        }
        let count = [self.positions.len(), self.uvs.len(), self.normals.len()][kind] as i64;
        // 0 points nowhere, and stays out of range.
        let from_first = if written < 0 { (count + written).max(i64::from(i32::MIN)) } else { i64::from(i32::MIN) };
        corners.push(from_first as i32 as u32);
        self.relative[kind].push(at as u32);
    }

    fn truncate(&mut self, kind: usize, length: usize) {
        self.corners[kind].truncate(length);
        while self.relative[kind].pop_if(|at| *at as usize >= length).is_some() {}
    }

    /// Makes all indices count from the file's first vertex, when there are `before` in the pieces before this one. Whether
    /// all exist, when there are `total` in the file; texture coordinates or normals of which it has none are done without.
    pub(super) fn make_absolute(&mut self, before: Counts, total: Counts) -> bool {
        let mut sound = true;
        for kind in 0..3 {
            let corners = &mut self.corners[kind];
            if kind > 0 && total[kind] == 0 {
                self.misses[kind - 1] = !corners.is_empty();
                corners.clear();
                continue;
            }
            for &at in &self.relative[kind] {
                let index = i64::from(corners[at as usize] as i32) + before[kind] as i64;
                corners[at as usize] = u32::try_from(index).unwrap_or(NONE - 1);
            }
            sound &= corners.iter().all(|&index| (index as usize) < total[kind] || index == NONE);
        }
        sound
    }
}

/// The first face in `text` with a corner that does not exist, when there are `before` vertices, texture coordinates and
/// normals before the text and `total` in the file.
pub(super) fn find_out_of_range(text: &str, before: Counts, total: Counts) -> Option<Mistake> {
    let mut so_far = before;
    for (line, statement) in logical_lines(text) {
        let (key, rest) = split_key(without_comment(&statement).trim());
        match key {
            "v" => so_far[0] += 1,
            "vt" => so_far[1] += 1,
            "vn" => so_far[2] += 1,
            "f" | "fo" => {
                for (kind, written) in rest.split_ascii_whitespace().filter_map(corner).flat_map(|c| (0..3).zip(c)) {
                    let Some(written) = written.filter(|_| kind == 0 || total[kind] > 0) else { continue };
                    let index = if written < 0 { so_far[kind] as i64 + 1 + written } else { written };
                    if index < 1 || index > total[kind] as i64 {
                        let count = if written > 0 { total[kind] } else { so_far[kind] };
                        return Some(Mistake {
                            line,
                            expected: format!("a {} that exists (there are {count})", KINDS[kind]),
                            found: format!("number {written}"),
                        });
                    }
                }
            }
            _ => {}
        }
    }
    None
}

/// Lines of `text` as [`logical_lines`] counts them; a carriage return alone ends one, too.
fn physical_lines(text: &str) -> usize {
    let returns = |text: &str| text.split('\r').skip(1).filter(|after| !after.starts_with('\n')).count();
    text.bytes().filter(|byte| *byte == b'\n').count() + returns(text)
}

fn split_key(statement: &str) -> (&str, &str) {
    let end = statement.find(|c: char| c.is_ascii_whitespace()).unwrap_or(statement.len());
    (&statement[..end], statement[end..].trim_start())
}

/// A position, perhaps with a weight that divides it, or with a colour.
fn vertex(words: &str) -> Option<(Vec3, Option<Vec3>)> {
    let position = Vec3::from_array(numbers(words)?);
    let mut rest = words.split_ascii_whitespace().skip(3);
    match (rest.next(), rest.next(), rest.next(), rest.next()) {
        (None, ..) => Some((position, None)),
        (Some(weight), None, ..) => number(weight).filter(|w| *w != 0.0).map(|w| (position / w, None)),
        (Some(red), Some(green), Some(blue), None) => {
            let colour = Vec3::new(number(red)?, number(green)?, number(blue)?);
            Some((position, Some(colour)))
        }
        _ => None,
    }
}

/// Texture coordinates; a single one stands for a row.
fn uv(words: &str) -> Option<Vec2> {
    match numbers(words) {
        Some(uv) => Some(Vec2::from_array(uv)),
        None if words.split_ascii_whitespace().count() == 1 => Some(Vec2::new(number(words)?, 0.0)),
        None => None,
    }
}

/// The first numbers of `words`.
fn numbers<const N: usize>(words: &str) -> Option<[f32; N]> {
    let mut words = words.split_ascii_whitespace();
    let mut numbers = [0.0; N];
    for slot in &mut numbers {
        *slot = number(words.next()?)?;
    }
    Some(numbers)
}

/// A number. What other programs write for NaN and infinity (`1.#INF`, `-nan(ind)`) becomes NaN, so that its triangles can
/// be dropped.
fn number(word: &str) -> Option<f32> {
    word.parse().ok().or_else(|| {
        let bare = word.trim_start_matches(['+', '-']).to_ascii_lowercase();
        (bare.starts_with("nan") || bare.starts_with("inf") || bare.contains('#')).then_some(f32::NAN)
    })
}

/// Indices of vertex, texture coordinate and normal as written: `1`, `1/2`, `1//3` or `1/2/3`.
fn corner(word: &str) -> Option<[Option<i64>; 3]> {
    // Where there are no slashes, looking for them costs as much as reading the number.
    if let Ok(vertex) = word.parse() {
        return Some([Some(vertex), None, None]);
    }
    let mut corner = [None; 3];
    for (kind, index) in word.split('/').enumerate() {
        *corner.get_mut(kind)? = match index.is_empty() {
            true if kind > 0 => None,
            _ => Some(index.parse().ok()?),
        };
    }
    Some(corner)
}
