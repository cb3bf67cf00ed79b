//! From the pieces of an OBJ file to one mesh.

use std::collections::{BTreeSet, HashMap, VecDeque};
use std::ops::Range;
use std::path::Path;

use glam::{Vec2, Vec3, Vec4};

use super::super::Mesh;
use super::super::mtl::MtlLibrary;
use super::super::notes::Notes;
use super::super::picture_file::srgb_to_linear;
use super::super::source::without_comment;
use super::piece::{Event, KINDS, NONE, Piece};
use super::polygon::{cut_concave, fan};

/// Puts the pieces of the file `path` together, whose indices all count from the file's first vertex. Materials are looked
/// for in the libraries named so far, then in those named later; all are read into `library`.
pub(super) fn assemble(mut pieces: Vec<Piece>, library: &mut MtlLibrary, path: &Path, notes: &mut Notes) -> Mesh {
    note_left_out(&pieces, path, notes);
    let mut attributes = Attributes::take(&mut pieces);
    let mut palette = Palette::of(&pieces, library);
    let mut mesh = Mesh::default();
    let faces = pieces.iter().map(|piece| piece.faces).sum();
    mesh.triangles.reserve(faces);
    mesh.materials.reserve(faces);
    for piece in pieces {
        let mut events = piece.events.iter().peekable();
        let mut first = 0;
        for face in 0..piece.faces {
            while let Some((_, event)) = events.next_if(|(before, _)| *before <= face) {
                palette.heed(event, library);
            }
            let corners = first..first + piece.arities.get(face).map_or(3, |arity| *arity as usize);
            first = corners.end;
            attributes.add_face(&piece, corners, &mut mesh.triangles);
            mesh.materials.resize(mesh.triangles.len(), palette.current);
        }
        events.for_each(|(_, event)| palette.heed(event, library));
    }
    palette.note_missing(path, notes);
    if mesh.materials.contains(&NONE) {
        // A colour is the whole colour where there is no material to multiply it with.
        let default = library.default_material(!attributes.colours.is_empty()) as u32;
        mesh.materials.iter_mut().filter(|m| **m == NONE).for_each(|m| *m = default);
    }
    attributes.into_mesh(mesh)
}

/// Says what of the file is not shown.
fn note_left_out(pieces: &[Piece], path: &Path, notes: &mut Notes) {
    for (missing, kind) in KINDS[1..].iter().enumerate() {
        if pieces.iter().any(|piece| piece.misses[missing]) {
            let path = path.display();
            notes.add(format!("{path}: faces refer to {kind}s, of which the file has none; they do without"));
        }
    }
    let sum = |of: &dyn Fn(&Piece) -> usize| pieces.iter().map(of).sum::<usize>();
    let left_out = [
        (sum(&|piece| piece.skipped_faces), "faces with fewer than three corners"),
        (sum(&|piece| piece.skipped[0]), "statements of points"),
        (sum(&|piece| piece.skipped[1]), "statements of lines"),
        (sum(&|piece| piece.skipped[2]), "curves and curved surfaces"),
    ];
    for (count, what) in left_out.into_iter().filter(|(count, _)| *count > 0) {
        notes.add(format!("{}: {count} {what} left out", path.display()));
    }
}

/// Materials by name.
struct Palette {
    /// Those of libraries so far, the last one of each name.
    by_name: HashMap<String, u32>,
    /// Those of all libraries, the first one of each name.
    anywhere: HashMap<String, u32>,
    /// The libraries that each statement names, in order, by their materials; but not those that the one before it names, too.
    to_come: VecDeque<Vec<Range<usize>>>,
    /// Of the faces to come; [`NONE`] when no library has it.
    current: u32,
    missing: BTreeSet<String>,
}

impl Palette {
    /// Reads what the statements in `pieces` name into `library`.
    fn of(pieces: &[Piece], library: &mut MtlLibrary) -> Self {
        let mut palette = Self {
            by_name: HashMap::new(),
            anywhere: HashMap::new(),
            to_come: VecDeque::new(),
            current: NONE,
            missing: BTreeSet::new(),
        };
        let mut before = vec![];
        for (_, event) in pieces.iter().flat_map(|piece| &piece.events) {
            let Event::Library(names) = event else { continue };
            let added = library.add(names);
            let is_new = added != before;
            palette.to_come.push_back(if is_new { added.clone() } else { vec![] });
            for (name, index) in library.named(&added).filter(|_| is_new) {
                palette.anywhere.entry(name).or_insert(index);
            }
            before = added;
        }
        palette
    }

    fn heed(&mut self, event: &Event, library: &MtlLibrary) {
        match event {
            Event::Library(_) => {
                let libraries = self.to_come.pop_front().unwrap_or_default();
                self.by_name.extend(library.named(&libraries));
            }
            Event::Use(name) => {
                // Names may hold what looks like a comment.
                let bare = without_comment(name).trim_end();
                let found = self.find(name).or_else(|| self.find(bare));
                if found.is_some() || !bare.is_empty() {
                    self.current = found.unwrap_or(NONE);
                }
                if found.is_none() && !bare.is_empty() {
                    self.missing.insert(bare.into());
                }
            }
        }
    }

    fn find(&self, name: &str) -> Option<u32> {
        self.by_name.get(name).or_else(|| self.anywhere.get(name)).copied()
    }

    fn note_missing(&self, path: &Path, notes: &mut Notes) {
        for name in &self.missing {
            notes.add(format!("{}: no library has material '{name}'; grey is used", path.display()));
        }
    }
}

/// What corners of faces point to, and the vertices made of it.
struct Attributes {
    positions: Vec<Vec3>,
    /// Of the positions; empty where there are none.
    colours: Vec<Vec4>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// Different corners, when there is more to them than positions. Else vertices are positions.
    vertices: Option<Vertices>,
}

/// Corners with the same indices are one vertex. Those that share a position are chained: most have one or two.
#[derive(Default)]
struct Vertices {
    /// Indices of position, texture coordinate and normal, and the next vertex with that position.
    all: Vec<([u32; 3], u32)>,
    /// The first vertex with each position.
    first: Vec<u32>,
}

impl Vertices {
    fn number(&mut self, corner: [u32; 3]) -> u32 {
        let mut at = self.first[corner[0] as usize];
        while at != NONE {
            let (there, next) = self.all[at as usize];
            if there == corner {
                return at;
            }
            at = next;
        }
        let number = self.all.len() as u32;
        let first = &mut self.first[corner[0] as usize];
        self.all.push((corner, *first));
        *first = number;
        number
    }
}

impl Attributes {
    /// Takes them out of the pieces.
    fn take(pieces: &mut [Piece]) -> Self {
        let count: [usize; 3] = std::array::from_fn(|kind| pieces.iter().map(|piece| piece.counts()[kind]).sum());
        let mut all = Self {
            positions: Vec::with_capacity(count[0]),
            colours: colours(pieces, count[0]),
            uvs: Vec::with_capacity(count[1]),
            normals: Vec::with_capacity(count[2]),
            vertices: None,
        };
        for piece in &mut *pieces {
            all.positions.extend(std::mem::take(&mut piece.positions));
            all.uvs.extend(std::mem::take(&mut piece.uvs));
            all.normals.extend(std::mem::take(&mut piece.normals));
        }
        if pieces.iter().any(|piece| !piece.corners[1].is_empty() || !piece.corners[2].is_empty()) {
            all.vertices = Some(Vertices { all: vec![], first: vec![NONE; count[0]] });
        }
        all
    }

    /// Cuts a face of `piece` into triangles.
    fn add_face(&mut self, piece: &Piece, corners: std::ops::Range<usize>, triangles: &mut Vec<[u32; 3]>) {
        let vertex = |vertices: &mut Option<Vertices>, corner: usize| {
            let of = |kind: usize| piece.corners[kind].get(corner).copied().unwrap_or(NONE);
            vertices.as_mut().map_or_else(|| of(0), |vertices| vertices.number([of(0), of(1), of(2)]))
        };
        if corners.len() == 3 {
            triangles.push([0, 1, 2].map(|i| vertex(&mut self.vertices, corners.start + i)));
            return;
        }
        let outline: Vec<Vec3> =
            piece.corners[0][corners.clone()].iter().map(|&v| self.positions[v as usize]).collect();
        let face: Vec<u32> = corners.map(|corner| vertex(&mut self.vertices, corner)).collect();
        let of_face = |t: [usize; 3]| t.map(|corner| face[corner]);
        match cut_concave(&outline) {
            None => triangles.extend(fan(face.len()).map(of_face)),
            Some(cut) => triangles.extend(cut.into_iter().map(of_face)),
        }
    }

    /// Gives the triangles of `mesh` their vertices.
    fn into_mesh(self, mut mesh: Mesh) -> Mesh {
        let Some(Vertices { all, .. }) = self.vertices else {
            mesh.positions = self.positions;
            mesh.colours = self.colours;
            return mesh;
        };
        mesh.positions = all.iter().map(|(corner, _)| self.positions[corner[0] as usize]).collect();
        if !self.colours.is_empty() {
            mesh.colours = all.iter().map(|(corner, _)| self.colours[corner[0] as usize]).collect();
        }
        if all.iter().any(|(corner, _)| corner[1] != NONE) {
            let uv = |index: u32| if index == NONE { Vec2::ZERO } else { self.uvs[index as usize] };
            mesh.uvs = all.iter().map(|(corner, _)| uv(corner[1])).collect();
        }
        if all.iter().any(|(corner, _)| corner[2] != NONE) {
            let normal = |index: u32| if index == NONE { Vec3::ZERO } else { self.normals[index as usize] };
            mesh.normals = all.iter().map(|(corner, _)| normal(corner[2]).normalize_or_zero()).collect();
        }
        mesh
    }
}

/// Colours of all `count` vertices, made linear; none where no piece has any, or where all are white, which says nothing.
///
/// What is above 1 anywhere is of 255. Numbers that are none count as white.
fn colours(pieces: &mut [Piece], count: usize) -> Vec<Vec4> {
    let written = || pieces.iter().flat_map(|piece| &piece.colours);
    if written().all(|colour| *colour == Vec3::ONE) {
        return vec![];
    }
    let white = if written().any(|colour| colour.max_element() > 1.0) { 255.0 } else { 1.0 };
    let linear = |c: f32| if c.is_finite() { srgb_to_linear((c / white).clamp(0.0, 1.0)) } else { 1.0 };
    let mut all = Vec::with_capacity(count);
    for piece in pieces {
        let vertices = all.len() + piece.positions.len();
        let own = std::mem::take(&mut piece.colours);
        all.extend(own.into_iter().map(|colour| Vec3::from(colour.to_array().map(linear)).extend(1.0)));
        all.resize(vertices, Vec4::ONE);
    }
    all
}
