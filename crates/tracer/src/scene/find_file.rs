//! Files that other files name.

use std::path::{Path, PathBuf};

/// The path of `name`, as a file in `folder` calls another: backslashes are taken for slashes, and when there is no such
/// file, one that differs in case only will do. `None` when there is none either.
pub(super) fn find_file(folder: &Path, name: &str) -> Option<PathBuf> {
    let mended = name.trim().replace('\\', "/");
    let direct = folder.join(&mended);
    if direct.is_file() {
        return Some(direct);
    }
    let mut found = folder.to_path_buf();
    for part in mended.split('/').filter(|part| !part.is_empty() && *part != ".") {
        found = if part == ".." { found.join(part) } else { find_ignoring_case(&found, part)? };
    }
    found.is_file().then_some(found)
}

fn find_ignoring_case(folder: &Path, name: &str) -> Option<PathBuf> {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let exact = folder.join(name);
    if exact.exists() {
        return Some(exact);
    }
    let wanted = name.to_lowercase();
    let entries = std::fs::read_dir(here).ok()?.flatten();
    let mut same: Vec<_> =
        entries.map(|e| e.file_name()).filter(|n| n.to_string_lossy().to_lowercase() == wanted).collect();
    // Folders are listed in no particular order.
    same.sort();
    same.first().map(|n| folder.join(n))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_in_the_folder_above() {
        let folder = tempfile::tempdir().unwrap();
        for (name, file) in [("Sub", "x.mtl"), ("Other", "Y.png")] {
            std::fs::create_dir(folder.path().join(name)).unwrap();
            std::fs::write(folder.path().join(name).join(file), b"").unwrap();
        }
        let found = find_file(&folder.path().join("Sub"), "../other/y.PNG").unwrap();
        assert!(found.ends_with("Sub/../Other/Y.png"));
        assert_eq!(find_file(folder.path(), "sub"), None);
    }
}
