//! Mesh files by path: read whole, written whole or not at all.

use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

use super::uri::fetch;
use super::{Format, ReadError, ReadMesh, WriteError, gzip, read_attributed_with, read_with};
use crate::mesh::RawMesh;

/// Reads the mesh file at `path`, in `format`, or in the one that its name or else its content shows.
///
/// # Errors
/// [`ReadError`], without the path: the caller knows it.
///
/// ```
/// let error = neural_mesh::io::read_path("no/such/mesh.obj".as_ref(), None).unwrap_err();
/// assert!(error.to_string().starts_with("cannot be read"));
/// ```
pub fn read_path(path: &Path, format: Option<Format>) -> Result<RawMesh, ReadError> {
    let bytes = bytes_of(path)?;
    let fetch = |uri: &str| fetch(path.parent().unwrap_or(Path::new("")), uri);
    let read = |format| read_with(&bytes, format, &fetch);
    as_what_it_is(&bytes, path, format, read, |mesh| !mesh.faces.is_empty())
}

/// [`read_attributed`](super::read_attributed) of the file at `path`, in `format`, or in the one that its name or else its content shows.
///
/// # Errors
/// [`ReadError`], without the path: the caller knows it.
///
/// ```
/// let folder = tempfile::tempdir().unwrap();
/// let path = folder.path().join("mesh.obj");
/// std::fs::write(&path, "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
/// let read = neural_mesh::io::read_attributed_path(&path, None).unwrap();
/// assert_eq!((read.extra.folder.as_deref(), read.extra.material_libraries.len()), (path.parent(), 1));
/// ```
pub fn read_attributed_path(path: &Path, format: Option<Format>) -> Result<ReadMesh, ReadError> {
    let bytes = bytes_of(path)?;
    let fetch = |uri: &str| fetch(path.parent().unwrap_or(Path::new("")), uri);
    let read = |format| read_attributed_with(&bytes, format, &fetch);
    let mut read = as_what_it_is(&bytes, path, format, read, |read| !read.mesh.faces.is_empty())?;
    read.extra.folder = path.parent().map(Path::to_path_buf);
    Ok(read)
}

/// The bytes of a file, unpacked.
pub(super) fn bytes_of(path: &Path) -> Result<Vec<u8>, ReadError> {
    let bytes =
        std::fs::read(path).map_err(|error| ReadError::file(format!("cannot be read: {error}"), "check the path"))?;
    match gzip::unpacked(&bytes)? {
        Cow::Owned(unpacked) => Ok(unpacked),
        Cow::Borrowed(_) => Ok(bytes),
    }
}

/// Reads bytes in the format that was asked for or that the name says; a file with the wrong extension is read as what it
/// is, where reading it as what it says is of no use.
fn as_what_it_is<T>(
    bytes: &[u8],
    path: &Path,
    format: Option<Format>,
    read: impl Fn(Option<Format>) -> Result<T, ReadError>,
    is_useful: impl Fn(&T) -> bool,
) -> Result<T, ReadError> {
    let named = format.or_else(|| Format::from_path(path));
    let first = read(named);
    match Format::from_content(bytes) {
        Some(shown) if format.is_none() && named != Some(shown) && !first.as_ref().is_ok_and(is_useful) => {
            read(Some(shown)).or(first)
        }
        _ => first,
    }
}

/// The bytes as a file of this name holds them: compressed where it ends in `.gz`, if they are not already.
///
/// # Errors
/// [`WriteError`] where this build compresses nothing.
///
/// ```
/// use neural_mesh::io::packed_by_name;
/// assert_eq!(packed_by_name("mesh.obj".as_ref(), b"v 0 0 0\n").unwrap().as_ref(), b"v 0 0 0\n");
/// let packed = packed_by_name("mesh.obj.gz".as_ref(), b"v 0 0 0\n").unwrap();
/// assert_eq!(neural_mesh::io::read(&packed, None).unwrap().positions, [[0.0; 3]]);
/// ```
pub fn packed_by_name<'a>(path: &Path, bytes: &'a [u8]) -> Result<Cow<'a, [u8]>, WriteError> {
    let is_packed = matches!(bytes, [0x1f, 0x8b, ..]);
    if is_packed || matches!(Format::without_gz(path), Cow::Borrowed(_)) {
        return Ok(Cow::Borrowed(bytes));
    }
    let problem = |error| WriteError { what: format!("cannot be compressed: {error}: choose a name without .gz") };
    gzip::packed(bytes).map(Cow::Owned).map_err(problem)
}

/// Writes `bytes` to `path`, compressed where its name ends in `.gz`, through a temporary file beside it, so that the file appears whole or not at all.
///
/// An existing file is replaced only with `force`. A device or a pipe is written to directly.
///
/// # Errors
/// [`WriteError`], without the path: the caller knows it.
///
/// ```
/// let folder = tempfile::tempdir().unwrap();
/// let path = folder.path().join("mesh.obj");
/// neural_mesh::io::write_path(&path, b"v 0 0 0\n", false).unwrap();
/// assert!(neural_mesh::io::write_path(&path, b"", false).is_err());
/// ```
pub fn write_path(path: &Path, bytes: &[u8], force: bool) -> Result<(), WriteError> {
    let bytes = &packed_by_name(path, bytes)?;
    let problem =
        |error: std::io::Error| WriteError { what: format!("cannot be written: {error}: check folder and disk") };
    if path.metadata().is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return std::fs::write(path, bytes).map_err(problem);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = new_file_in(folder).map_err(problem)?;
    file.write_all(bytes).map_err(problem)?;
    let placed = if force { file.persist(path) } else { file.persist_noclobber(path) };
    match placed {
        Err(error) if error.error.kind() == std::io::ErrorKind::AlreadyExists => {
            Err(WriteError { what: "exists already: choose another name or allow replacing it".into() })
        }
        placed => placed.map(drop).map_err(|error| problem(error.error)),
    }
}

/// A temporary file with the permissions of any new file (the crate's own default is the owner's alone).
fn new_file_in(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".neural-mesh-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_extension_does_not_mislead() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.stl");
        std::fs::write(&path, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").unwrap();
        assert_eq!(read_path(&path, None).unwrap().faces.len(), 1);
        assert!(read_path(&path, Some(Format::Stl)).is_err());
    }

    #[test]
    fn nothing_is_left_behind_where_writing_fails() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("taken");
        std::fs::create_dir(&path).unwrap();
        assert!(write_path(&path, b"words", true).is_err());
        assert!(write_path(&path.join("no/such/folder"), b"words", true).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn files_are_replaced_only_by_force() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.obj");
        write_path(&path, b"one", false).unwrap();
        assert!(write_path(&path, b"two", false).unwrap_err().to_string().contains("exists already"));
        assert_eq!(std::fs::read(&path).unwrap(), b"one");
        write_path(&path, b"two", true).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_written_to_not_replaced() {
        use std::os::unix::fs::FileTypeExt;
        write_path("/dev/null".as_ref(), b"words", true).unwrap();
        assert!(std::fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    }
}
