//! A folder with a stack and what its picture should be.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use reconstruct::metrics::{Comparison, Reference, compare};
use stack::file::{read_buckets, read_picture, read_stack};
use stack::{FeatureStack, Image};

/// A stack, its references, and what Open Image Denoise made of it.
pub struct Folder {
    pub name: String,
    pub stack: FeatureStack,
    /// Two of independent noise, or one twice.
    pub references: [Image; 2],
    /// With albedo and normal, where the folder has that.
    pub oidn: Option<Image>,
    /// From colour alone, where the folder has that.
    pub oidn_colour: Option<Image>,
}

impl Folder {
    /// Opens b0.exr, b1.exr … (one of them alone is a stack that knows nothing about its noise), ref1.exr, perhaps ref2.exr,
    /// oidn.exr and oidn-colour.exr.
    ///
    /// # Errors
    /// When a file that must be there cannot be read.
    pub fn open(folder: &Path) -> Result<Self> {
        let buckets: Vec<PathBuf> =
            (0..).map(|b| folder.join(format!("b{b}.exr"))).take_while(|file| file.exists()).collect();
        let read = if let [alone] = &buckets[..] { read_stack(alone) } else { read_buckets(&buckets) };
        let read = read.with_context(|| format!("{}: b0.exr, b1.exr …", folder.display()))?;
        let picture = |name: &str| Some(folder.join(name)).filter(|file| file.exists()).map(|file| read_picture(&file));
        let first = read_picture(&folder.join("ref1.exr"))?;
        let second = picture("ref2.exr").transpose()?.unwrap_or_else(|| first.clone());
        let name = folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let (oidn, oidn_colour) = (picture("oidn.exr").transpose()?, picture("oidn-colour.exr").transpose()?);
        Ok(Self { name, stack: read.stack, references: [first, second], oidn, oidn_colour })
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
