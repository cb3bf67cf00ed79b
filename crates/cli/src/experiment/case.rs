//! A folder of another renderer's buckets with its references, which methods are judged on.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use reconstruct::metrics::{Comparison, Reference, compare};
use stack::file::{FileError, ReadStack, read_buckets, read_picture, read_stack};
use stack::{FeatureStack, Image, Knobs};

use crate::args::ExperimentArgs;
use crate::failure::usage;
use crate::settings::{Preset, Settings};

/// A stack of buckets with two references.
pub struct Case {
    /// The folder's name.
    pub name: String,
    pub stack: FeatureStack,
    pub references: [Image; 2],
    /// What other programs made of it, by name.
    pub others: Vec<(&'static str, Image)>,
}

impl Case {
    /// Opens every folder given: b0.exr, b1.exr …, ref1.exr and ref2.exr, perhaps oidn.exr.
    ///
    /// # Errors
    /// When a file cannot be read or the buckets do not fit together.
    pub fn open_all(args: &ExperimentArgs) -> Result<Vec<Self>> {
        args.inputs.iter().map(|folder| Self::open(folder)).collect()
    }

    /// Opens one folder.
    ///
    /// # Errors
    /// As [`Self::open_all`].
    pub fn open(folder: &Path) -> Result<Self> {
        let second = |_: &Image| Ok(read_picture(&folder.join("ref2.exr"))?);
        Self::with(folder, read_buckets(&buckets(folder)), second, &["oidn"])
    }

    /// Opens a folder that may hold less: b0.exr alone is a stack that knows nothing about its noise, and one reference
    /// stands for two. Perhaps it has oidn-colour.exr, made from colour alone, and
    /// oidn-clean.exr, made with features denoised first.
    ///
    /// # Errors
    /// When a file that must be there cannot be read.
    pub fn open_poor(folder: &Path) -> Result<Self> {
        let buckets = buckets(folder);
        let read = if let [alone] = &buckets[..] { read_stack(alone) } else { read_buckets(&buckets) };
        let second = |first: &Image| Ok(picture_if_there(folder, "ref2")?.unwrap_or_else(|| first.clone()));
        Self::with(folder, read, second, &["oidn", "oidn-colour", "oidn-clean"])
    }

    fn with(
        folder: &Path,
        read: Result<ReadStack, FileError>,
        second: impl FnOnce(&Image) -> Result<Image>,
        others: &[&'static str],
    ) -> Result<Self> {
        let stack = read.with_context(|| format!("{}: b0.exr, b1.exr …", folder.display()))?.stack;
        let first = read_picture(&folder.join("ref1.exr"))?;
        let second = second(&first)?;
        let mut found = Vec::new();
        for name in others {
            found.extend(picture_if_there(folder, name)?.map(|picture| (*name, picture)));
        }
        let name = folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok(Self { name, stack, references: [first, second], others: found })
    }

    /// What the other program called `name` made of it, where that is known.
    pub fn other(&self, name: &str) -> Option<&Image> {
        self.others.iter().find(|(other, _)| *other == name).map(|(_, picture)| picture)
    }

    /// Measures `picture` against both references.
    ///
    /// # Errors
    /// When sizes differ.
    pub fn judge(&self, picture: &Image) -> Result<Comparison> {
        judged_by(picture, &self.references).with_context(|| self.name.clone())
    }
}

/// Measures `picture` against two references.
///
/// # Errors
/// When sizes differ.
pub fn judged_by(picture: &Image, [first, second]: &[Image; 2]) -> Result<Comparison> {
    Ok(compare(picture, &Reference { second: Some(second), ..Reference::new(first) })?)
}

/// The files b0.exr, b1.exr … of a folder.
fn buckets(folder: &Path) -> Vec<PathBuf> {
    (0..).map(|b| folder.join(format!("b{b}.exr"))).take_while(|file| file.exists()).collect()
}

fn picture_if_there(folder: &Path, name: &str) -> Result<Option<Image>, FileError> {
    let file = Some(folder.join(format!("{name}.exr"))).filter(|file| file.exists());
    file.map(|file| read_picture(&file)).transpose()
}

/// Flags with their values.
pub type Flags = &'static [(&'static str, &'static str)];

/// A name, and the preset and flags that make it.
pub type Entry = (&'static str, Preset, Flags);

/// The settings of a preset, changed by `flags`.
///
/// # Errors
/// When there is no such flag, or it does not take the value.
pub fn settings(preset: Preset, flags: Flags) -> Result<Settings> {
    let mut settings = Settings::of(preset);
    for (flag, value) in flags {
        settings.set(flag, value).ok_or_else(|| usage(format!("no setting is called {flag}")))??;
    }
    Ok(settings)
}
