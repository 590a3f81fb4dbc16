//! Folders from which companion files are read.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use super::FilesRead;
use crate::mesh::fallible_allocation::with_fallible_allocation;

/// Folder in which the companion files of a mesh file are looked for.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Folder {
    /// Folder on disk, and the files in it that were read.
    Disk(PathBuf, FilesRead),
    /// Files in memory, by normalised relative path.
    Memory(Arc<BTreeMap<PathBuf, Arc<[u8]>>>),
}

impl Folder {
    /// Returns the folder of a mesh file on disk.
    pub fn from_file(file: &Path) -> Self {
        Self::Disk(file.parent().unwrap_or(Path::new("")).to_path_buf(), FilesRead::from_mesh_path(file))
    }

    /// Returns the files on disk that were read: the mesh and its companion files so far.
    pub fn files_read(&self) -> FilesRead {
        match self {
            Self::Disk(_, read) => read.clone(),
            Self::Memory(_) => FilesRead::default(),
        }
    }

    /// Makes a folder of files in memory; drops files whose names lead out of the folder.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::{Folder, read_looks, read_attributed_in};
    /// let library = b"newmtl red\nKd 1 0 0\n".to_vec();
    /// let folder = Folder::in_memory([("a.mtl", library)]);
    /// let obj = b"mtllib a.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    /// let read = read_attributed_in(obj, "a.obj", &folder)?;
    /// assert_eq!(read_looks(&read.extra, false).0.of_groups[0].colour, [1.0, 0.0, 0.0]);
    /// # Ok::<(), neural_mesh::io::ReadError>(())
    /// ```
    pub fn in_memory<N: AsRef<str>, B: Into<Arc<[u8]>>>(files: impl IntoIterator<Item = (N, B)>) -> Self {
        let normalised = |(name, bytes): (N, B)| Some((inner_path(Path::new(""), name.as_ref())?, bytes.into()));
        Self::Memory(Arc::new(files.into_iter().filter_map(normalised).collect()))
    }

    pub(super) fn has_file(&self, path: &Path) -> bool {
        match self {
            Self::Disk(folder, _) => or_current(folder).join(path).is_file(),
            Self::Memory(files) => files.contains_key(path),
        }
    }

    /// Returns the path of a file with its links resolved; rejects outside files unless `allow_outside`.
    pub(super) fn resolve(&self, path: &Path, allow_outside: bool) -> Result<PathBuf, FileProblem> {
        let folder = match self {
            Self::Memory(files) => {
                return if files.contains_key(path) { Ok(path.into()) } else { Err(FileProblem::Missing) };
            }
            Self::Disk(folder, _) => or_current(folder),
        };
        // Links are followed before the comparison: a link may lead out of the folder.
        let inside = folder.canonicalize().map_err(|_| FileProblem::Missing)?;
        let source = folder.join(path).canonicalize().map_err(|_| FileProblem::Missing)?;
        if !source.starts_with(inside) && !allow_outside {
            return Err(FileProblem::Outside);
        }
        if !source.is_file() {
            return Err(FileProblem::NotAFile);
        }
        Ok(source)
    }

    pub(super) fn read(&self, source: &Path) -> Result<Arc<[u8]>, FileProblem> {
        match self {
            Self::Disk(_, read) => {
                read.add(source);
                with_fallible_allocation(|| std::fs::read(source)).map(Arc::from).map_err(FileProblem::Unreadable)
            }
            Self::Memory(files) => files.get(source).cloned().ok_or(FileProblem::Missing),
        }
    }

    pub(super) fn relative_path(&self, source: &Path) -> Option<PathBuf> {
        match self {
            Self::Disk(folder, _) => {
                let folder = or_current(folder).canonicalize().ok()?;
                source.strip_prefix(folder).ok().map(Path::to_path_buf)
            }
            Self::Memory(_) => Some(source.into()),
        }
    }
}

impl PartialEq for Folder {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Disk(folder, _), Self::Disk(other, _)) => folder == other,
            (Self::Memory(files), Self::Memory(others)) => files == others,
            _ => false,
        }
    }
}

/// Joins `name` to `base`; `None` if the path leaves the root of `base`.
pub(super) fn inner_path(base: &Path, name: &str) -> Option<PathBuf> {
    // Windows programs write backslashes, which are valid in names elsewhere but hardly used.
    let name = name.replace('\\', "/");
    // A colon means a drive or a URL.
    if name.contains([':', '\0']) {
        return None;
    }
    let mut path = PathBuf::new();
    for part in base.components().chain(Path::new(&name).components()) {
        match part {
            Component::Normal(name) => path.push(name),
            Component::CurDir => {}
            // Upward steps are resolved in the path itself, before any link could redirect them.
            Component::ParentDir if path.pop() => {}
            _ => return None,
        }
    }
    (!path.as_os_str().is_empty()).then_some(path)
}

#[derive(Debug)]
pub(super) enum FileProblem {
    Outside,
    // The file is absent, or its name is invalid.
    Missing,
    NotAFile,
    Unreadable(std::io::Error),
}

impl std::fmt::Display for FileProblem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Outside => write!(f, "is outside the folder of the asset and is not read"),
            Self::Missing => write!(f, "is missing"),
            Self::NotAFile => write!(f, "is not a file"),
            Self::Unreadable(error) => write!(f, "cannot be read ({error})"),
        }
    }
}

fn or_current(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_down_or_nowhere() {
        let base = Path::new("materials");
        for (name, expected) in [
            ("a.png", Some("materials/a.png")),
            ("./x/a b.png", Some("materials/x/a b.png")),
            ("..\\textures\\a.png", Some("textures/a.png")),
            ("../a.png", Some("a.png")),
            ("../../a.png", None),
            ("x/../../../a.png", None),
            ("/etc/passwd", None),
            ("C:\\a.png", None),
            ("\\\\host\\a.png", None),
            ("..", None),
        ] {
            assert_eq!(inner_path(base, name), expected.map(PathBuf::from), "{name}");
        }
    }

    #[test]
    fn what_is_in_memory_is_found_by_its_path_alone() {
        let folder = Folder::in_memory([("maps\\a.png", b"png".to_vec()), ("../b.png", Vec::new())]);
        let path = Path::new("maps/a.png");
        assert!(folder.has_file(path) && !folder.has_file(Path::new("a.png")) && !folder.has_file(Path::new("b.png")));
        let source = folder.resolve(path, false).unwrap();
        assert_eq!(
            (&*folder.read(&source).unwrap(), folder.relative_path(&source).as_deref()),
            (&b"png"[..], Some(path))
        );
        assert!(matches!(folder.resolve(Path::new("/etc/passwd"), true), Err(FileProblem::Missing)));
    }
}
