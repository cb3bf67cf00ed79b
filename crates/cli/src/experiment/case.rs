//! A folder of another renderer's buckets with its references, which methods are judged on.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use reconstruct::metrics::{Comparison, Reference, compare};
use stack::file::{read_buckets, read_picture};
use stack::{FeatureStack, Image, Knobs};

use crate::args::{ExperimentArgs, Preset};
use crate::failure::usage;
use crate::settings::Settings;

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
        let buckets: Vec<PathBuf> =
            (0..).map(|b| folder.join(format!("b{b}.exr"))).take_while(|file| file.exists()).collect();
        let name = folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let read = read_buckets(&buckets).with_context(|| format!("{}: b0.exr, b1.exr …", folder.display()))?;
        let references = [read_picture(&folder.join("ref1.exr"))?, read_picture(&folder.join("ref2.exr"))?];
        let oidn = Some(folder.join("oidn.exr")).filter(|file| file.exists());
        let others = oidn.map(|file| read_picture(&file)).transpose()?.map(|picture| ("oidn", picture));
        Ok(Self { name, stack: read.stack, references, others: others.into_iter().collect() })
    }

    /// Measures `picture` against both references.
    ///
    /// # Errors
    /// When sizes differ.
    pub fn judge(&self, picture: &Image) -> Result<Comparison> {
        let reference = Reference { second: Some(&self.references[1]), ..Reference::new(&self.references[0]) };
        compare(picture, &reference).with_context(|| self.name.clone())
    }
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
