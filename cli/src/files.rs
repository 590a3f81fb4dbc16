//! Files and standard streams; files appear complete or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use neural_mesh::io;
use serde::Serialize;
use tempfile::NamedTempFile;

use crate::failure::Failure;
use crate::interrupt;
use crate::names::is_stream;
use crate::plain::plain_json;
use crate::words::{stdout_failure, write_stdout};

pub use crate::content::read;

const MOST_LINKS: usize = 40;

/// Result in a temporary file, to be moved into place.
pub struct Pending {
    temporary: NamedTempFile,
    name: PathBuf,
    place: PathBuf,
    force: bool,
}

impl Pending {
    /// Returns whether `place` is the final path.
    pub fn is_at(&self, place: &Path) -> bool {
        self.place == place
    }

    fn is_there(&self) -> bool {
        let there = std::fs::read(&self.place).ok();
        !self.force && there.is_some() && there == std::fs::read(self.temporary.path()).ok()
    }
}

/// Rejects two results with one file, and paths where no file can be written.
pub fn check_places<'a>(paths: impl IntoIterator<Item = &'a Path>, force: bool) -> Result<(), Failure> {
    let paths: Vec<&Path> = paths.into_iter().collect();
    let mut places = Vec::new();
    for path in &paths {
        let place = destination(path)?;
        // Links are resolved here, since two names may lead to one file.
        if places.contains(&place) {
            let what = format!("{}: is the file of two results: give each result its own file", path.display());
            return Err(Failure::Usage(what));
        }
        places.push(place);
    }
    paths.into_iter().try_for_each(|path| check_place(path, force))
}

/// Rejects a path where no file can be written or an existing one may not be replaced.
pub fn check_place(path: &Path, force: bool) -> Result<(), Failure> {
    let place = destination(path)?;
    let folder = folder_of(&place);
    if !folder.is_dir() {
        return Err(Failure::in_file(path, format!("there is no folder {}: create it first", folder.display())));
    }
    match std::fs::symlink_metadata(path) {
        Err(_) => {}
        Ok(_) if !force => return Err(exists(path)),
        // The target of a link may be missing still; folders and devices are never replaced.
        Ok(_) if std::fs::metadata(path).is_ok_and(|target| !target.is_file()) => {
            return Err(Failure::in_file(path, "is not a file: choose another name"));
        }
        Ok(_) => {}
    }
    check_folder(path, folder)
}

fn check_folder(path: &Path, folder: &Path) -> Result<(), Failure> {
    let unwritable = |error| {
        let what = format!("cannot create a file in {}: {error}: choose another folder", folder.display());
        Failure::in_file(path, what)
    };
    // Only a test file shows reliably whether the folder can be written to.
    new_file_in(folder).map(drop).map_err(unwritable)
}

/// Returns the file behind links, so that links stay and their targets are replaced.
fn destination(path: &Path) -> Result<PathBuf, Failure> {
    let mut place = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(next) = std::fs::read_link(&place) else { return Ok(in_own_folder(&place)) };
        place = folder_of(&place).join(next);
    }
    Err(Failure::in_file(path, "is a link that never ends: choose another name"))
}

pub fn in_own_folder(path: &Path) -> PathBuf {
    let folder = std::fs::canonicalize(folder_of(path));
    match (folder, path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_path_buf(),
    }
}

/// Writes bytes to a temporary file in the final folder, compressed for names in `.gz`.
pub fn prepare(name: &Path, bytes: &[u8], force: bool) -> Result<Pending, Failure> {
    let place = destination(name)?;
    let problem = |error| Failure::in_file(name, format!("cannot be written: {error}: check the folder and the disk"));
    // The temporary file is in the final folder, so that moving it into place is a rename.
    let mut temporary = new_file_in(folder_of(&place)).map_err(problem)?;
    let bytes = io::compress_by_name(name, bytes).map_err(|error| Failure::in_file(name, error))?;
    temporary.write_all(&bytes).map_err(problem)?;
    Ok(Pending { temporary, name: name.into(), place, force })
}

/// Prepares a JSON file if `path` is given; returns the bytes instead for standard output.
pub fn prepare_json(
    path: Option<&Path>,
    value: &impl Serialize,
    force: bool,
    pending: &mut Vec<Pending>,
) -> Result<Option<Vec<u8>>, Failure> {
    let Some(path) = path else { return Ok(None) };
    let json = serde_json::to_string_pretty(value).map_err(|error| Failure::in_file(path, error))? + "\n";
    if is_stream(path) {
        return Ok(Some(plain_json(&json).into_bytes()));
    }
    pending.push(prepare(path, json.as_bytes(), force)?);
    Ok(None)
}

/// Moves all results into place without interruption.
pub fn place(pending: Vec<Pending>) -> Result<(), Failure> {
    interrupt::without_interruption(|| pending.into_iter().try_for_each(place_one))
}

/// Moves results into place; accepts an identical file of an earlier run.
pub fn place_or_find(pending: Vec<Pending>) -> Result<(), Failure> {
    place(pending.into_iter().filter(|pending| !pending.is_there()).collect())
}

fn place_one(pending: Pending) -> Result<(), Failure> {
    let Pending { temporary, name, place, force } = pending;
    // Another program may have created the file meanwhile; only --force replaces it.
    let placed = if force { temporary.persist(&place) } else { temporary.persist_noclobber(&place) };
    placed.map(drop).map_err(|error| match error.error.kind() {
        std::io::ErrorKind::AlreadyExists => exists(&name),
        _ => Failure::in_file(
            &name,
            format!("cannot be renamed from its temporary name: {}: check the folder", error.error),
        ),
    })
}

pub fn write_to_stdout(bytes: &[u8]) -> Result<(), Failure> {
    write_stdout(bytes).map_err(|error| stdout_failure(&error))
}

fn exists(path: &Path) -> Failure {
    Failure::in_file(path, "exists already: choose another name, or replace it with --force")
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Creates a temporary file with the permissions of an ordinary one.
fn new_file_in(folder: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".neural-mesh-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The default of the crate is private to the owner.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    interrupt::with_temporary(|| builder.tempfile_in(folder))
}
