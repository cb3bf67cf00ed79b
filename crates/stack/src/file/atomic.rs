//! Files that appear whole or not at all.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use super::FileError;

/// Writes `path` through a temporary file beside it, which replaces `path` only once `write` has succeeded.
///
/// # Errors
/// When the folder cannot be written to, or `write` fails; what was at `path` is then untouched.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), FileError>,
) -> Result<(), FileError> {
    let failed = |source| FileError::io(path, "write", source);
    let mut temporary = temporary_beside(path).map_err(failed)?;
    let mut buffered = BufWriter::new(temporary.as_file_mut());
    write(&mut buffered)?;
    buffered.flush().map_err(failed)?;
    drop(buffered);
    temporary.as_file().sync_all().map_err(failed)?;
    temporary.persist(path).map_err(|refused| failed(refused.error))?;
    Ok(())
}

/// Finds out, before any work is done, whether `path` can be written.
///
/// # Errors
/// When `path` is a folder, or its folder is absent or refuses a new file.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    if path.is_dir() {
        return Err(FileError::Folder { path: path.into() });
    }
    temporary_beside(path).map(drop).map_err(|source| FileError::io(path, "write", source))
}

fn temporary_beside(path: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".tamis-");
    // A temporary file is private by default; the result shall have the permissions any new file gets.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_litter() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        std::fs::write(&path, "old").unwrap();
        let outcome = write_atomically(&path, |out| {
            out.write_all(b"half a new fi").unwrap();
            Err(FileError::TooFewBuckets { found: 1 })
        });
        assert!(outcome.is_err());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn an_absent_folder_is_found_before_the_work() {
        let folder = tempfile::tempdir().unwrap();
        assert!(check_writable(&folder.path().join("absent/picture.exr")).is_err());
        assert!(check_writable(folder.path()).is_err());
        check_writable(&folder.path().join("picture.exr")).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
