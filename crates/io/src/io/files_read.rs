//! Files that a run has read: nothing that it writes replaces one, but the result its own mesh.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rustc_hash::FxHashSet;

use super::{OutputFile, WriteError};

/// Device and inode of a file.
type FileId = (u64, u64);

/// Files that a run has read, known by device and inode, so that links and other names lead to the same file.
///
/// Clones share the list.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::FilesRead;
/// let folder = tempfile::tempdir().unwrap();
/// let path = folder.path().join("mesh.obj");
/// std::fs::write(&path, "v 0 0 0").unwrap();
/// let read = FilesRead::from_mesh_path(&path);
/// assert!(read.check(&path, true).is_ok() && read.check(&path, false).is_err());
/// ```
#[derive(Clone, Debug, Default)]
pub struct FilesRead {
    all: Arc<Mutex<FxHashSet<FileId>>>,
    /// The mesh, which the result may replace.
    mesh: Option<FileId>,
}

impl FilesRead {
    /// Makes the list of a run that reads the mesh at `path`.
    pub fn from_mesh_path(path: &Path) -> Self {
        Self::default().with_mesh(find_id(path))
    }

    /// Makes the list of a run that reads its mesh from an open file, such as standard input.
    pub fn from_open_mesh(file: &File) -> Self {
        Self::default().with_mesh(find_open_id(file))
    }

    /// Returns the same list for a run of several that reads the mesh at `path`.
    pub fn with_mesh_path(&self, path: &Path) -> Self {
        self.clone().with_mesh(find_id(path))
    }

    fn with_mesh(self, mesh: Option<FileId>) -> Self {
        self.lock().extend(mesh);
        Self { mesh, ..self }
    }

    /// Adds the file at `path`, behind links; anything but a file is left out.
    pub fn add(&self, path: &Path) {
        self.lock().extend(find_id(path));
    }

    /// Adds an open file.
    pub fn add_open(&self, file: &File) {
        self.lock().extend(find_open_id(file));
    }

    /// Adds all files of another list; returns this list, whose mesh is the other's if it had none.
    pub fn join(&self, other: &Self) -> Self {
        let others = other.lock().clone();
        self.lock().extend(others);
        let mesh = self.mesh.or(other.mesh);
        Self { mesh, ..self.clone() }
    }

    /// Rejects the path of a file that was read; a result (`is_result`) may be at that of the mesh.
    ///
    /// # Errors
    /// [`WriteError`], without the path.
    pub fn check(&self, path: &Path, is_result: bool) -> Result<(), WriteError> {
        match find_id(path).filter(|id| self.lock().contains(id)) {
            Some(id) if !is_result || self.mesh != Some(id) => {
                Err(WriteError::new("is read in this run, so it is never replaced: choose another name"))
            }
            _ => Ok(()),
        }
    }

    /// Forgets the mesh, which a result at `path` is about to replace: its number may go to a new file.
    pub fn forget_mesh(&self, path: &Path) {
        if let Some(id) = find_id(path).filter(|id| self.mesh.as_ref() == Some(id) && !has_other_names(path)) {
            self.lock().remove(&id);
        }
    }

    /// Rejects companion files in `folder` of which one would change a file that was read.
    ///
    /// # Errors
    /// [`WriteError`] names the file.
    pub fn check_companions(&self, folder: &Path, files: &[OutputFile]) -> Result<(), WriteError> {
        files
            .iter()
            .filter(|file| !is_equal(&folder.join(&file.path), &file.bytes))
            .try_for_each(|file| self.check(&folder.join(&file.path), false).map_err(|error| file.problem(error)))
    }

    fn lock(&self) -> MutexGuard<'_, FxHashSet<FileId>> {
        self.all.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Folder of the results, in which companion files get new names where a file that was read would change.
#[derive(Clone, Debug)]
pub struct OutputFolder {
    /// The folder.
    pub path: PathBuf,
    /// Files that were read.
    pub read: FilesRead,
    /// True if no file of the folder may change, read or not.
    pub keeps_all: bool,
}

impl OutputFolder {
    /// Returns whether a file there may not change.
    pub fn keeps(&self, path: &Path) -> bool {
        let path = self.path.join(path);
        self.keeps_all && path.symlink_metadata().is_ok() || self.read.check(&path, false).is_err()
    }

    /// Returns `path`, or a new name if another file there may not change: `t.png` becomes `t-16.png` with suffix `16`.
    pub fn free_path(&self, path: &Path, bytes: &[u8], suffix: Option<&str>, taken: &[OutputFile]) -> PathBuf {
        if !self.keeps(path) || is_equal(&self.path.join(path), bytes) {
            return path.into();
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let named = |more: &str| {
            let ending = path.extension().map_or_else(String::new, |ending| format!(".{}", ending.to_string_lossy()));
            path.with_file_name(format!("{stem}{more}{ending}"))
        };
        let suffix = suffix.map_or_else(String::new, |suffix| format!("-{suffix}"));
        let first = (!suffix.is_empty()).then(|| named(&suffix));
        let mut names = first.into_iter().chain((1..).map(|n| named(&format!("{suffix}-{n}"))));
        // A new name replaces nothing, so that a file that is read later is safe, too.
        let is_free = |name: &PathBuf| {
            let at = self.path.join(name);
            let is_taken = taken.iter().any(|file| file.path.as_os_str().eq_ignore_ascii_case(name));
            !is_taken && (at.symlink_metadata().is_err() || is_equal(&at, bytes))
        };
        names.find(is_free).unwrap_or_else(|| path.into())
    }
}

/// Returns whether the file at `path` has these bytes.
fn is_equal(path: &Path, bytes: &[u8]) -> bool {
    let has_length = |found: std::fs::Metadata| found.is_file() && found.len() == bytes.len() as u64;
    std::fs::metadata(path).is_ok_and(has_length) && std::fs::read(path).is_ok_and(|there| there == bytes)
}

#[cfg(unix)]
fn file_id(found: &std::fs::Metadata) -> Option<FileId> {
    use std::os::unix::fs::MetadataExt;
    found.is_file().then(|| (found.dev(), found.ino()))
}

#[cfg(unix)]
fn find_id(path: &Path) -> Option<FileId> {
    file_id(&std::fs::metadata(path).ok()?)
}

#[cfg(unix)]
fn find_open_id(file: &File) -> Option<FileId> {
    file_id(&file.metadata().ok()?)
}

#[cfg(unix)]
fn has_other_names(path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    std::fs::metadata(path).is_ok_and(|found| found.nlink() > 1)
}

// Numbers of files are not given again elsewhere.
#[cfg(not(unix))]
fn has_other_names(_: &Path) -> bool {
    true
}

#[cfg(windows)]
fn find_id(path: &Path) -> Option<FileId> {
    find_open_id(&File::open(path).ok()?)
}

#[cfg(windows)]
fn find_open_id(file: &File) -> Option<FileId> {
    let found = winapi_util::file::information(file).ok()?;
    file.metadata().ok()?.is_file().then(|| (found.volume_serial_number(), found.file_index()))
}

// Pages have no files.
#[cfg(not(any(unix, windows)))]
fn find_id(_: &Path) -> Option<FileId> {
    None
}

#[cfg(not(any(unix, windows)))]
fn find_open_id(_: &File) -> Option<FileId> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_of(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        files.iter().for_each(|name| std::fs::write(folder.path().join(name), name).unwrap());
        folder
    }

    #[test]
    fn links_lead_to_the_file_that_was_read() {
        let folder = folder_of(&["a.ply", "t.png", "other"]);
        let in_folder = |name: &str| folder.path().join(name);
        std::fs::hard_link(in_folder("t.png"), in_folder("hard.png")).unwrap();
        let read = FilesRead::from_mesh_path(&in_folder("a.ply"));
        read.add(&in_folder("t.png"));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("hard.png", in_folder("soft.png")).unwrap();
            assert!(read.check(&in_folder("soft.png"), true).is_err());
        }
        for name in ["t.png", "hard.png"] {
            assert!(read.check(&in_folder(name), true).is_err(), "{name}");
        }
        assert!(read.check(&in_folder("a.ply"), true).is_ok() && read.check(&in_folder("a.ply"), false).is_err());
        for name in ["other", "new", "."] {
            assert!(read.check(&in_folder(name), false).is_ok(), "{name}");
        }
    }

    #[test]
    fn new_names_replace_nothing() {
        let folder = folder_of(&["t.png", "t-16.png", "b"]);
        let read = FilesRead::default();
        read.add(&folder.path().join("t.png"));
        let output = OutputFolder { path: folder.path().into(), read, keeps_all: false };
        let free = |name: &str, bytes: &[u8], suffix| output.free_path(name.as_ref(), bytes, suffix, &[]);
        assert_eq!(free("t.png", b"t.png", None), Path::new("t.png"));
        assert_eq!(free("t.png", b"new", None), Path::new("t-1.png"));
        assert_eq!(free("t.png", b"new", Some("8")), Path::new("t-8.png"));
        assert_eq!(free("t.png", b"new", Some("16")), Path::new("t-16-1.png"));
        assert_eq!(free("t.png", b"t-16.png", Some("16")), Path::new("t-16.png"));
        assert_eq!(free("b", b"new", None), Path::new("b"));
        let all = OutputFolder { keeps_all: true, ..output.clone() };
        assert_eq!(all.free_path("b".as_ref(), b"new", None, &[]), Path::new("b-1"));
        let taken = [OutputFile { path: "T-1.png".into(), bytes: Vec::new() }];
        assert_eq!(output.free_path("t.png".as_ref(), b"new", None, &taken), Path::new("t-2.png"));
    }
}
