//! MTL files: materials for OBJ.

mod convert;
mod entry;
mod maps;
mod texture_line;

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::Vec3;

use super::SceneError;
use super::find_file::find_file;
use super::notes::Notes;
use super::source::{read_text, without_comment};
use super::textures::TextureFiles;
use crate::material::Material;
use entry::MtlEntry;

/// All materials of the libraries an OBJ file names, in the order they were added.
#[derive(Debug)]
pub(super) struct MtlLibrary {
    folder: PathBuf,
    entries: Vec<MtlEntry>,
    /// Files that have been read, and which entries they hold.
    read: HashMap<PathBuf, Range<usize>>,
    missing: Vec<String>,
    fault: Option<SceneError>,
}

/// The names in a list with blanks between them. A blank behind a backslash is of a name.
fn several(names: &str) -> Vec<String> {
    const OF_A_NAME: &str = "\u{0}";
    let names = names.replace("\\ ", OF_A_NAME);
    names.split_whitespace().map(|name| name.replace(OF_A_NAME, " ")).collect()
}

impl MtlLibrary {
    /// A library without materials, for files in `folder`.
    pub(super) fn new(folder: PathBuf) -> Self {
        Self { folder, entries: vec![], read: HashMap::new(), missing: vec![], fault: None }
    }

    /// Adds what a `mtllib` line names, one file or several, each of which is read once; returns which materials each has.
    /// Mistakes are kept for [`into_materials`](Self::into_materials).
    pub(super) fn add(&mut self, names: &str) -> Vec<Range<usize>> {
        let files = match find_file(&self.folder, names) {
            Some(file) => vec![file],
            None => several(without_comment(names)).iter().filter_map(|name| self.find(name)).collect(),
        };
        files.iter().map(|file| self.entries_of(file)).collect()
    }

    /// Names and indices of the materials in `ranges`.
    pub(super) fn named(&self, ranges: &[Range<usize>]) -> impl Iterator<Item = (String, u32)> {
        ranges.iter().cloned().flatten().map(|index| (self.entries[index].name.clone(), index as u32))
    }

    fn find(&mut self, name: &str) -> Option<PathBuf> {
        let found = find_file(&self.folder, name);
        if found.is_none() && !self.missing.iter().any(|missing| missing == name) {
            self.missing.push(name.into());
        }
        found
    }

    /// Which entries `file` has.
    fn entries_of(&mut self, file: &Path) -> Range<usize> {
        if let Some(entries) = self.read.get(file) {
            return entries.clone();
        }
        let first = self.entries.len();
        match read_text(file).and_then(|text| entry::parse(&text, file)) {
            Ok(entries) => self.entries.extend(entries),
            Err(fault) => self.fault = self.fault.take().or(Some(fault)),
        }
        self.read.insert(file.into(), first..self.entries.len());
        first..self.entries.len()
    }

    /// Index of the material for faces that have none: grey, or white where their vertices are `coloured`.
    pub(super) fn default_material(&mut self, coloured: bool) -> usize {
        let mut default = MtlEntry::new("default".into());
        default.diffuse = coloured.then_some(Vec3::ONE);
        self.entries.push(default);
        self.entries.len() - 1
    }

    /// Makes materials; textures are read for those in `used` only.
    ///
    /// # Errors
    /// The first mistake in a library.
    pub(super) fn into_materials(self, used: &[u32], notes: &mut Notes) -> Result<Vec<Material>, SceneError> {
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        for name in &self.missing {
            notes.add(format!("material library '{name}' is missing in {}", self.folder.display()));
        }
        let mut is_used = vec![false; self.entries.len()];
        used.iter().for_each(|&index| is_used[index as usize] = true);
        let mut textures = TextureFiles::new(&self.folder);
        let make = |(entry, used): (&MtlEntry, bool)| entry.material(used.then_some((&mut textures, notes)));
        Ok(self.entries.iter().zip(is_used).map(make).collect())
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn names_in_a_list_may_hold_blanks_behind_backslashes() {
        assert_eq!(super::several(r"a.mtl  my\ own\ b.mtl dir\c.mtl"), ["a.mtl", "my own b.mtl", r"dir\c.mtl"]);
    }
}
