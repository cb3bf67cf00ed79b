//! Files that appear whole or not at all.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::temporaries::{Listed, TEMPORARIES};
use super::{Action, FileError};

/// Writes `path` through a temporary file beside it, which replaces `path` only once `write` has succeeded. A file that was
/// there keeps its permissions, and a symbolic link stays one: what it points to is written.
///
/// # Errors
/// When the folder cannot be written to, or `write` fails; what was at `path` is then untouched.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), FileError>,
) -> Result<(), FileError> {
    let failed = |source| FileError::io(path, Action::Write, source);
    let target = target_of(path);
    let (mut temporary, _listed) = temporary_beside(&target).map_err(failed)?;
    let mut buffered = BufWriter::new(temporary.as_file_mut());
    write(&mut buffered)?;
    buffered.flush().map_err(failed)?;
    drop(buffered);
    temporary.as_file().sync_all().map_err(failed)?;
    temporary.persist(target).map_err(|refused| failed(refused.error))?;
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
    temporary_beside(&target_of(path)).map(drop).map_err(|source| FileError::io(path, Action::Write, source))
}

/// The longest chain of symbolic links that is followed; it is Linux's.
const MOST_LINKS: usize = 40;

/// What `path` is in the end, where it is a symbolic link; perhaps nothing yet.
fn target_of(path: &Path) -> PathBuf {
    let mut target = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(next) = target.read_link() else { break };
        // A relative one begins where the link is.
        target = target.parent().unwrap_or(Path::new("")).join(next);
    }
    target
}

/// A file in the folder of `path`, with the permissions of what is there, and its place in the list.
fn temporary_beside(path: &Path) -> std::io::Result<(tempfile::NamedTempFile, Listed<'static>)> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".tamis-");
    // A temporary file is private by default; the result shall have the permissions any new file gets.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let (temporary, listed) =
        TEMPORARIES.list(|| builder.tempfile_in(folder)).map_err(|error| without_place(&error))?;
    if let Some(old) = path.metadata().ok().filter(std::fs::Metadata::is_file)
        && old.permissions() != temporary.as_file().metadata()?.permissions()
    {
        temporary.as_file().set_permissions(old.permissions())?;
    }
    Ok((temporary, listed))
}

/// An error of `tempfile` without the name of its own file, of which nobody has heard.
fn without_place(error: &std::io::Error) -> std::io::Error {
    let text = error.to_string();
    let what = text.rsplit_once(" at path ").map_or(&*text, |(what, _)| what);
    std::io::Error::new(error.kind(), what)
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

    #[cfg(unix)]
    #[test]
    fn permissions_and_links_stay_as_they_are() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let [file, link, there, later] =
            ["a.exr", "link.exr", "disk", "disk/b.exr"].map(|name| folder.path().join(name));
        std::fs::create_dir(&there).unwrap();
        std::fs::write(&file, "old").unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o600)).unwrap();
        symlink("a.exr", &link).unwrap();
        let write = |path: &Path| {
            check_writable(path).unwrap();
            write_atomically(path, |out| out.write_all(b"new").map_err(|e| FileError::io(path, Action::Write, e)))
                .unwrap();
        };
        write(&link);
        assert!(link.is_symlink() && !file.is_symlink());
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "new");
        assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o600);
        std::fs::remove_file(&link).unwrap();
        symlink("disk/b.exr", &link).unwrap();
        write(&link);
        assert!(link.is_symlink() && later.is_file(), "it may point to what is not there yet");
    }

    #[test]
    fn an_absent_folder_is_found_before_the_work() {
        let folder = tempfile::tempdir().unwrap();
        let error = check_writable(&folder.path().join("absent/picture.exr")).unwrap_err();
        let why = std::error::Error::source(&error).unwrap().to_string();
        assert!(why.contains("No such file") && !why.contains(".tamis-"), "{why}");
        assert!(check_writable(folder.path()).is_err());
        check_writable(&folder.path().join("picture.exr")).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
