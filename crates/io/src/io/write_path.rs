//! Writing of files, whole or not at all.

use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

use super::{Format, WriteError, gzip};

/// Compresses bytes if the file name ends in `.gz` and they are not yet compressed.
///
/// # Errors
/// [`WriteError`] if this build cannot compress.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::compress_by_name;
/// assert_eq!(compress_by_name("mesh.obj".as_ref(), b"v 0 0 0\n").unwrap().as_ref(), b"v 0 0 0\n");
/// let packed = compress_by_name("mesh.obj.gz".as_ref(), b"v 0 0 0\n").unwrap();
/// assert_eq!(neural_mesh::io::read(&packed, None).unwrap().positions, [[0.0; 3]]);
/// ```
pub fn compress_by_name<'a>(path: &Path, bytes: &'a [u8]) -> Result<Cow<'a, [u8]>, WriteError> {
    // Compressing twice would give a file that no reader unpacks.
    let is_packed = matches!(bytes, [0x1f, 0x8b, ..]);
    if is_packed || matches!(Format::without_gz(path), Cow::Borrowed(_)) {
        return Ok(Cow::Borrowed(bytes));
    }
    let problem = |error| WriteError::new(format!("cannot be compressed: {error}: choose a name without .gz"));
    gzip::compress(bytes).map(Cow::Owned).map_err(problem)
}

/// Writes a file whole or not at all; compresses it if its name ends in `.gz`.
///
/// An existing file is replaced only with `force`. Devices and pipes are written directly.
///
/// # Errors
/// [`WriteError`], without the path.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// let folder = tempfile::tempdir().unwrap();
/// let path = folder.path().join("mesh.obj");
/// neural_mesh::io::write_path(&path, b"v 0 0 0\n", false).unwrap();
/// assert!(neural_mesh::io::write_path(&path, b"", false).is_err());
/// ```
pub fn write_path(path: &Path, bytes: &[u8], force: bool) -> Result<(), WriteError> {
    let bytes = &compress_by_name(path, bytes)?;
    let problem = |error: std::io::Error| WriteError::new(format!("cannot be written: {error}: check folder and disk"));
    // A rename would replace the device or pipe itself.
    if path.metadata().is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return std::fs::write(path, bytes).map_err(problem);
    }
    // The temporary file is in the same folder, so that the final rename stays within one file system.
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = new_file_in(folder).map_err(problem)?;
    file.write_all(bytes).map_err(problem)?;
    // Creation without replacing is one step of the system: no file that appears meanwhile is lost.
    let placed = if force { file.persist(path) } else { file.persist_noclobber(path) };
    match placed {
        Err(error) if error.error.kind() == std::io::ErrorKind::AlreadyExists => {
            Err(WriteError::new("exists already: choose another name or allow replacing it"))
        }
        placed => placed.map(drop).map_err(|error| problem(error.error)),
    }
}

fn new_file_in(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".neural-mesh-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The default of `tempfile` is private to the user.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

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
