//! Mesh files by path: read whole, written whole or not at all.

use std::io::Write;
use std::path::Path;

use super::{Format, ReadError, WriteError, read};
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
    let bytes =
        std::fs::read(path).map_err(|error| ReadError::file(format!("cannot be read: {error}"), "check the path"))?;
    let named = format.or_else(|| Format::from_path(path));
    let mesh = read(&bytes, named);
    match Format::from_content(&bytes) {
        // A file with the wrong extension is read as what it is.
        Some(shown) if format.is_none() && named != Some(shown) && is_useless(&mesh) => {
            read(&bytes, Some(shown)).or(mesh)
        }
        _ => mesh,
    }
}

/// Writes `bytes` to `path` through a temporary file beside it, so that the file appears whole or not at all.
///
/// An existing file is replaced only with `force`.
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
    let problem =
        |error: std::io::Error| WriteError { what: format!("cannot be written: {error}: check folder and disk") };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = new_file_in(folder).map_err(problem)?;
    file.write_all(bytes).map_err(problem)?;
    let placed = if force { file.persist(path) } else { file.persist_noclobber(path) };
    match placed {
        Err(error) if error.error.kind() == std::io::ErrorKind::AlreadyExists => {
            Err(WriteError { what: "exists already: choose another name or force it".into() })
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

/// Whether reading failed or found nothing.
fn is_useless(mesh: &Result<RawMesh, ReadError>) -> bool {
    mesh.as_ref().map_or(true, |mesh| mesh.faces.is_empty())
}
