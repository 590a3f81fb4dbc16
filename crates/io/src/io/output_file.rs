//! Files to be written into one folder.

use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};

use super::{WriteError, write_path};

/// File to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFile {
    /// Relative path in the output folder.
    pub path: PathBuf,
    /// Content.
    pub bytes: Vec<u8>,
}

impl OutputFile {
    pub(super) fn problem(&self, error: impl std::fmt::Display) -> WriteError {
        WriteError::new(format!("{}: {error}", self.path.display()))
    }
}

/// Writes files into `folder`, each whole or not at all, the first of the list last.
///
/// An existing file is replaced only with `force`, unless its bytes are equal.
///
/// # Errors
/// [`WriteError`] if a path or link leads out of the folder, two files have one path, or writing fails.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::{OutputFile, write_files};
/// let folder = tempfile::tempdir().unwrap();
/// let file = |path: &str| OutputFile { path: path.into(), bytes: b"bytes".to_vec() };
/// write_files(folder.path(), &[file("a.gltf"), file("textures/a.png")], false).unwrap();
/// assert!(folder.path().join("textures/a.png").is_file());
/// assert!(write_files(folder.path(), &[file("../a.gltf")], false).is_err());
/// ```
pub fn write_files(folder: &Path, files: &[OutputFile], force: bool) -> Result<(), WriteError> {
    for file in files {
        // All paths are checked before the first file is written.
        let is_inside = file.path.components().all(|part| matches!(part, Component::Normal(_)));
        if !is_inside || file.path.as_os_str().is_empty() {
            return Err(outside_error(&file.path));
        }
    }
    let mut known = HashSet::new();
    for file in files {
        if !known.insert(&file.path) {
            let name = file.path.display();
            return Err(WriteError::new(format!("two files would have the name {name}: choose another name")));
        }
    }
    // The first file names the others, so it is written last.
    files.iter().rev().try_for_each(|file| write_inside(folder, file, force))
}

fn write_inside(folder: &Path, file: &OutputFile, force: bool) -> Result<(), WriteError> {
    let problem = |error: std::io::Error| file.problem(error);
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let path = folder.join(&file.path);
    let parent = path.parent().unwrap_or(folder);
    // This precedes the creation of folders: the existing part of the path may be a link that leads outside.
    let existing = parent.ancestors().find(|place| place.exists()).unwrap_or(folder);
    // Canonical paths resolve links on both sides of the comparison.
    let (inside, existing) = (folder.canonicalize().map_err(problem)?, existing.canonicalize().map_err(problem)?);
    if !existing.starts_with(inside) {
        return Err(outside_error(&file.path));
    }
    std::fs::create_dir_all(parent).map_err(problem)?;
    // A texture shared by several outputs is written once and needs no `force`.
    if std::fs::read(&path).is_ok_and(|there| there == file.bytes) {
        return Ok(());
    }
    write_path(&path, &file.bytes, force).map_err(|error| file.problem(error))
}

fn outside_error(path: &Path) -> WriteError {
    WriteError::new(format!("{} leads out of the output folder: rename it in the asset", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: &str, bytes: &[u8]) -> OutputFile {
        OutputFile { path: path.into(), bytes: bytes.to_vec() }
    }

    #[test]
    fn nothing_leaves_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        std::fs::create_dir(&inner).unwrap();
        assert!(write_files(&inner, &[file("x", b"x"), file("./x", b"y")], true).is_err());
        for path in ["../x", "a/../../x", "/x", ".", "", "a/../x"] {
            assert!(write_files(&inner, &[file(path, b"x")], true).is_err(), "{path}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(folder.path(), inner.join("link")).unwrap();
            assert!(write_files(&inner, &[file("link/x", b"x")], true).is_err());
            assert!(write_files(&inner, &[file("link/new/x", b"x")], true).is_err());
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn the_same_bytes_need_no_force() {
        let folder = tempfile::tempdir().unwrap();
        write_files(folder.path(), &[file("a", b"1"), file("b/c", b"2")], false).unwrap();
        write_files(folder.path(), &[file("b/c", b"2")], false).unwrap();
        let error = write_files(folder.path(), &[file("a", b"other")], false).unwrap_err();
        assert!(error.what.starts_with("a: exists already"), "{error}");
        write_files(folder.path(), &[file("a", b"other")], true).unwrap();
        assert_eq!(std::fs::read(folder.path().join("a")).unwrap(), b"other");
    }
}
