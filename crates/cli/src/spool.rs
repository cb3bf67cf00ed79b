//! Inputs that can be read only once: standard input (`-`), pipes and what a shell makes of `<(…)`.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use stack::file::Source;
use tempfile::TempDir;

use crate::failure::{Blamed, fault_of, usage};

/// Files that stand for such inputs, as long as it lives. Readers look at a file several times, and go back and forth in it.
#[derive(Default)]
pub struct Spool {
    folder: Option<TempDir>,
    /// What was called so, and where it is now.
    moved: Vec<(PathBuf, PathBuf)>,
}

impl Spool {
    /// Where what is called `path` can be read as often as one likes: there, if it is a file.
    ///
    /// # Errors
    /// When it cannot be read to its end or stored.
    pub fn path(&mut self, path: &Path) -> Result<PathBuf> {
        if let Some((_, there)) = self.moved.iter().find(|(name, _)| name == path) {
            return Ok(there.clone());
        }
        let is_standard = path == Path::new("-");
        if !is_standard && path.metadata().map_or(true, |found| found.is_file() || found.is_dir()) {
            return Ok(path.into());
        }
        let mut bytes = Vec::new();
        let read = if is_standard {
            std::io::stdin().lock().read_to_end(&mut bytes)
        } else {
            File::open(path).and_then(|mut file| file.read_to_end(&mut bytes))
        };
        read.map_err(|error| usage(format!("{}: cannot be read: {error}", shown(path))))?;
        let there = self.place(&bytes)?;
        std::fs::write(&there, bytes).with_context(|| format!("{}: cannot be stored", shown(path)))?;
        self.moved.push((path.into(), there.clone()));
        Ok(there)
    }

    /// The same for `FILE` or `ROLE=FILE`.
    ///
    /// # Errors
    /// As [`Self::path`].
    pub fn text(&mut self, text: &str) -> Result<String> {
        let file = Source::parse(text).path;
        let there = self.path(&file)?;
        if there == file {
            return Ok(text.into());
        }
        let role = text.strip_suffix(&*file.to_string_lossy()).unwrap_or_default();
        Ok(format!("{role}{}", there.display()))
    }

    /// What the user called the input that can be read at `there`.
    pub fn name_of<'a>(&'a self, there: &'a Path) -> &'a Path {
        self.moved.iter().find(|(_, moved)| moved == there).map_or(there, |(name, _)| name)
    }

    /// What the user called the first input that was stored.
    pub fn first_name(&self) -> Option<String> {
        self.moved.first().map(|(name, _)| shown(name))
    }

    /// `outcome`, whose error calls what was stored as the user called it: nobody knows the copies, which are gone by then.
    ///
    /// # Errors
    /// That of `outcome`.
    pub fn naming<T>(&self, outcome: Result<T>) -> Result<T> {
        outcome.map_err(|error| {
            let said = format!("{error:#}");
            let rename = |text: String, (name, there): &(PathBuf, PathBuf)| {
                text.replace(&*there.to_string_lossy(), &shown(name))
            };
            let named = self.moved.iter().fold(said.clone(), rename);
            if named == said { error } else { Blamed { message: named, fault: fault_of(&error) }.into() }
        })
    }

    /// A name for what begins so: its end says what is in it, for there is no other.
    fn place(&mut self, bytes: &[u8]) -> Result<PathBuf> {
        let folder = match self.folder.take() {
            Some(folder) => folder,
            None => tempfile::Builder::new().prefix("tamis-").tempdir().context("no folder for temporary files")?,
        };
        let ending = match bytes {
            [b'P', b'F' | b'f', ..] => "pfm",
            [b'P', b'H' | b'h', ..] => "phm",
            [0x89, b'P', b'N', b'G', ..] => "png",
            [b'#', b'?', ..] => "hdr",
            _ => "exr",
        };
        let place = folder.path().join(format!("input{}.{ending}", self.moved.len()));
        self.folder = Some(folder);
        Ok(place)
    }
}

/// How messages call an input.
fn shown(path: &Path) -> String {
    if path == Path::new("-") { "standard input".into() } else { path.display().to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_stay_where_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.exr");
        std::fs::write(&file, "").unwrap();
        let mut spool = Spool::default();
        for path in [&file, folder.path(), Path::new("gone.exr")] {
            assert_eq!(spool.path(path).unwrap(), path);
        }
        let text = format!("albedo={}", file.display());
        assert_eq!(spool.text(&text).unwrap(), text);
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_read_once_and_keeps_its_role() {
        let mut spool = Spool::default();
        let moved = spool.text("albedo=/dev/null").unwrap();
        let file = moved.strip_prefix("albedo=").unwrap();
        assert!(file.ends_with(".exr") && Path::new(file).is_file(), "{moved}");
        assert_eq!(spool.path(Path::new("/dev/null")).unwrap(), Path::new(file));
        drop(spool);
        assert!(!Path::new(file).exists());
    }

    #[cfg(unix)]
    #[test]
    fn errors_call_a_copy_what_the_user_called_it_and_keep_their_exit_code() {
        let mut spool = Spool::default();
        let there = spool.path(Path::new("/dev/null")).unwrap();
        assert_eq!(spool.first_name().unwrap(), "/dev/null");
        assert_eq!([&there, Path::new("a.exr")].map(|path| spool.name_of(path)), ["/dev/null", "a.exr"].map(Path::new));
        let error = || stack::file::FileError::Folder { path: there.clone() };
        let named = spool.naming::<()>(Err(anyhow::Error::from(error()).context("--guide"))).unwrap_err();
        assert_eq!(format!("{named:#}"), "--guide: /dev/null: expected a file, found a folder");
        assert_eq!(fault_of(&named), stack::Fault::Input);
        let other = spool.naming::<()>(Err(usage("wrong"))).unwrap_err();
        assert!(other.is::<crate::failure::UsageError>(), "others stay as they are");
    }
}
