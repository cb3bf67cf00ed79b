//! Temporary files that are being written, so that a process that ends at once can take them along.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

/// Those of this process.
pub(super) static TEMPORARIES: Temporaries = Temporaries(Mutex::new(Vec::new()));

/// A list of files that shall not outlive the process.
pub(super) struct Temporaries(Mutex<Vec<PathBuf>>);

/// A file's place in a list, given up when it is dropped.
pub(super) struct Listed<'a> {
    list: &'a Temporaries,
    path: PathBuf,
}

impl Temporaries {
    /// Makes a file and lists it, with no moment in between.
    pub(super) fn list(
        &self,
        make: impl FnOnce() -> std::io::Result<NamedTempFile>,
    ) -> std::io::Result<(NamedTempFile, Listed<'_>)> {
        let mut paths = self.lock();
        let file = make()?;
        paths.push(file.path().into());
        let listed = Listed { list: self, path: file.path().into() };
        Ok((file, listed))
    }

    /// Removes all that are listed; as long as the guard lives, no more are made.
    fn remove(&self) -> MutexGuard<'_, Vec<PathBuf>> {
        let mut paths = self.lock();
        for path in paths.drain(..) {
            // One that is finished by now has another name.
            let _ = std::fs::remove_file(path);
        }
        paths
    }

    fn lock(&self) -> MutexGuard<'_, Vec<PathBuf>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Listed<'_> {
    fn drop(&mut self) {
        self.list.lock().retain(|path| *path != self.path);
    }
}

/// Ends the process with `code`, and leaves no half-written file behind.
pub fn exit_without_litter(code: i32) -> ! {
    let _no_more = TEMPORARIES.remove();
    std::process::exit(code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_being_written_is_removed_and_what_is_finished_stays() {
        let folder = tempfile::tempdir().unwrap();
        let temporaries = Temporaries(Mutex::new(Vec::new()));
        let make = || temporaries.list(|| NamedTempFile::new_in(folder.path())).unwrap();
        let (finished, listed) = make();
        finished.persist(folder.path().join("finished")).unwrap();
        drop(listed);
        let _writing = make();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
        drop(temporaries.remove());
        let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["finished"]);
    }
}
