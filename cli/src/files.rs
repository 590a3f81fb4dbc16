//! Bytes from and to the disk and the standard streams; files appear whole or not at all.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use neural_mesh::io;
use tempfile::NamedTempFile;

use crate::failure::Failure;
use crate::interrupt;
use crate::request::is_stream;
use crate::words::closed;

/// A result on its way to its place.
pub struct Pending {
    temporary: NamedTempFile,
    path: PathBuf,
    force: bool,
}

/// All bytes of a file, or of standard input.
pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let read = if is_stream(path) {
        std::io::stdin().lock().read_to_end(&mut bytes).map(|_| bytes)
    } else {
        std::fs::read(path)
    };
    read.map_err(|error| Failure::of(path, format!("cannot be read: {error}: check the path")))
}

/// Refuses, before any work, a place where no file can be put or where one stands that may not be replaced.
pub fn check_place(path: &Path, force: bool) -> Result<(), Failure> {
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(Failure::of(path, format!("there is no folder {}: create it first", folder.display())));
    }
    match std::fs::symlink_metadata(path) {
        Err(_) => Ok(()),
        Ok(_) if !force => Err(exists(path)),
        // A link that leads nowhere is replaced; a folder or a device is not.
        Ok(_) if std::fs::metadata(path).is_ok_and(|target| !target.is_file()) => {
            Err(Failure::of(path, "is not a file: choose another name"))
        }
        Ok(_) => Ok(()),
    }
}

/// Writes bytes, compressed where the name ends in `.gz`, to a temporary file in the folder where they will stand.
pub fn prepare(name: &Path, bytes: &[u8], force: bool) -> Result<Pending, Failure> {
    // Through a link, so that the link stays and the file behind it changes.
    let path = std::fs::canonicalize(name).unwrap_or_else(|_| name.to_path_buf());
    let problem = |error| Failure::of(&path, format!("cannot be written: {error}: check the folder and the disk"));
    let mut temporary = new_file_in(folder_of(&path)).map_err(problem)?;
    let bytes = io::packed_by_name(name, bytes).map_err(|error| Failure::of(name, error))?;
    temporary.write_all(&bytes).map_err(problem)?;
    Ok(Pending { temporary, path, force })
}

/// Puts all results in their places, one after another, uninterrupted.
pub fn place(pending: Vec<Pending>) -> Result<(), Failure> {
    interrupt::uninterrupted(|| pending.into_iter().try_for_each(place_one))
}

fn place_one(pending: Pending) -> Result<(), Failure> {
    let Pending { temporary, path, force } = pending;
    let placed = if force { temporary.persist(&path) } else { temporary.persist_noclobber(&path) };
    placed.map(drop).map_err(|error| match error.error.kind() {
        std::io::ErrorKind::AlreadyExists => exists(&path),
        _ => Failure::of(&path, format!("cannot be put in place: {}: check the folder", error.error)),
    })
}

/// Writes bytes to standard output.
pub fn write_to_stdout(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let written = out.write_all(bytes).and_then(|()| out.flush());
    written.map_err(|error| closed(&error))
}

fn exists(path: &Path) -> Failure {
    Failure::of(path, "exists already: choose another name, or replace it with --force")
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A temporary file with the permissions of any new file (the crate's own default is the owner's alone).
fn new_file_in(folder: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".neural-mesh-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    interrupt::with_temporary(|| builder.tempfile_in(folder))
}
