//! MTL files: materials for OBJ.

mod convert;
mod entry;
mod maps;
mod texture_line;

use std::path::{Path, PathBuf};

use super::SceneError;
use super::notes::Notes;
use super::obj::find_file;
use super::source::read_text;
use super::textures::TextureFiles;
use crate::material::Material;
use entry::MtlEntry;

/// All materials of the libraries an OBJ file names, in the order they were added.
#[derive(Debug)]
pub(super) struct MtlLibrary {
    folder: PathBuf,
    entries: Vec<MtlEntry>,
    missing: Vec<String>,
    fault: Option<SceneError>,
}

impl MtlLibrary {
    /// A library without materials, for files in `folder`.
    pub(super) fn new(folder: PathBuf) -> Self {
        Self { folder, entries: vec![], missing: vec![], fault: None }
    }

    /// Adds what a `mtllib` line names, one file or several; returns the names of the new materials. Mistakes are kept
    /// for [`into_materials`](Self::into_materials).
    pub(super) fn add(&mut self, names: &str) -> Vec<String> {
        let before = self.entries.len();
        match find_file(&self.folder, names) {
            Some(file) => self.add_file(&file),
            None => names.split_whitespace().for_each(|name| match find_file(&self.folder, name) {
                Some(file) => self.add_file(&file),
                None => self.missing.push(name.into()),
            }),
        }
        self.entries[before..].iter().map(|entry| entry.name.clone()).collect()
    }

    fn add_file(&mut self, file: &Path) {
        match read_text(file).and_then(|text| entry::parse(&text, file)) {
            Ok(entries) => self.entries.extend(entries),
            Err(fault) => self.fault = self.fault.take().or(Some(fault)),
        }
    }

    /// How many materials there are.
    pub(super) fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there is a material called `name`.
    pub(super) fn has(&self, name: &str) -> bool {
        self.entries.iter().any(|entry| entry.name == name)
    }

    /// Index of the material for faces that have none: grey.
    pub(super) fn default_material(&mut self) -> usize {
        self.entries.push(MtlEntry::new("default".into()));
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
