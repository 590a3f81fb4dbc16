//! Bytes from and to the disk and the standard streams; files appear whole or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use neural_mesh::io;
use serde::Serialize;
use tempfile::NamedTempFile;

use crate::failure::Failure;
use crate::interrupt;
use crate::names::is_stream;
use crate::plain::plain_json;
use crate::words::{closed, out};

pub use crate::content::read;

/// Links that are followed, as many as Linux follows.
const MOST_LINKS: usize = 40;

/// A result on its way to its place.
pub struct Pending {
    temporary: NamedTempFile,
    /// What it is called.
    name: PathBuf,
    /// Where it will stand.
    place: PathBuf,
    force: bool,
}

impl Pending {
    /// Whether it will stand in this place.
    pub fn is_at(&self, place: &Path) -> bool {
        self.place == place
    }

    fn is_there(&self) -> bool {
        let there = std::fs::read(&self.place).ok();
        !self.force && there.is_some() && there == std::fs::read(self.temporary.path()).ok()
    }
}

/// Refuses, before any work, results that would be one file, and places where none can be put.
pub fn check_places<'a>(paths: impl IntoIterator<Item = &'a Path>, force: bool) -> Result<(), Failure> {
    let paths: Vec<&Path> = paths.into_iter().collect();
    let mut places = Vec::new();
    for path in &paths {
        let place = destination(path)?;
        if places.contains(&place) {
            let what = format!("{}: is also the file of another result: give each its own file", path.display());
            return Err(Failure::Usage(what));
        }
        places.push(place);
    }
    paths.into_iter().try_for_each(|path| check_place(path, force))
}

/// Refuses, before any work, a place where no file can be put or where one stands that may not be replaced.
pub fn check_place(path: &Path, force: bool) -> Result<(), Failure> {
    let place = destination(path)?;
    let folder = folder_of(&place);
    if !folder.is_dir() {
        return Err(Failure::of(path, format!("there is no folder {}: create it first", folder.display())));
    }
    match std::fs::symlink_metadata(path) {
        Err(_) => {}
        Ok(_) if !force => return Err(exists(path)),
        // What a link leads to need not be there yet; a folder or a device is not replaced.
        Ok(_) if std::fs::metadata(path).is_ok_and(|target| !target.is_file()) => {
            return Err(Failure::of(path, "is not a file: choose another name"));
        }
        Ok(_) => {}
    }
    check_folder(path, folder)
}

/// Refuses a folder that takes no new file, by trying.
fn check_folder(path: &Path, folder: &Path) -> Result<(), Failure> {
    let unwritable = |error| {
        let what = format!("cannot create a file in {}: {error}: choose another folder", folder.display());
        Failure::of(path, what)
    };
    new_file_in(folder).map(drop).map_err(unwritable)
}

/// The file that a name stands for, through links: they stay, and what they lead to is replaced. Its folder has its own name,
/// if it is there.
fn destination(path: &Path) -> Result<PathBuf, Failure> {
    let mut place = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(next) = std::fs::read_link(&place) else { return Ok(in_own_folder(&place)) };
        place = folder_of(&place).join(next);
    }
    Err(Failure::of(path, "is a link that never ends: choose another name"))
}

/// The path with its folder by its one name without links.
pub fn in_own_folder(path: &Path) -> PathBuf {
    let folder = std::fs::canonicalize(folder_of(path));
    match (folder, path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_path_buf(),
    }
}

/// Writes bytes, compressed where the name ends in `.gz`, to a temporary file in the folder where they will stand.
pub fn prepare(name: &Path, bytes: &[u8], force: bool) -> Result<Pending, Failure> {
    let place = destination(name)?;
    let problem = |error| Failure::of(name, format!("cannot be written: {error}: check the folder and the disk"));
    let mut temporary = new_file_in(folder_of(&place)).map_err(problem)?;
    let bytes = io::compress_by_name(name, bytes).map_err(|error| Failure::of(name, error))?;
    temporary.write_all(&bytes).map_err(problem)?;
    Ok(Pending { temporary, name: name.into(), place, force })
}

/// Adds a JSON file to what is on its way to files, where one is asked for; gives its bytes where standard output is its place.
pub fn prepare_json(
    path: Option<&Path>,
    value: &impl Serialize,
    force: bool,
    pending: &mut Vec<Pending>,
) -> Result<Option<Vec<u8>>, Failure> {
    let Some(path) = path else { return Ok(None) };
    let json = serde_json::to_string_pretty(value).map_err(|error| Failure::of(path, error))? + "\n";
    if is_stream(path) {
        return Ok(Some(plain_json(&json).into_bytes()));
    }
    pending.push(prepare(path, json.as_bytes(), force)?);
    Ok(None)
}

/// Puts all results in their places, one after another, uninterrupted.
pub fn place(pending: Vec<Pending>) -> Result<(), Failure> {
    interrupt::uninterrupted(|| pending.into_iter().try_for_each(place_one))
}

/// As [`place`]; a file that stands in its place already, byte for byte, is one that an earlier run put there.
pub fn place_or_find(pending: Vec<Pending>) -> Result<(), Failure> {
    place(pending.into_iter().filter(|pending| !pending.is_there()).collect())
}

fn place_one(pending: Pending) -> Result<(), Failure> {
    let Pending { temporary, name, place, force } = pending;
    let placed = if force { temporary.persist(&place) } else { temporary.persist_noclobber(&place) };
    placed.map(drop).map_err(|error| match error.error.kind() {
        std::io::ErrorKind::AlreadyExists => exists(&name),
        _ => Failure::of(&name, format!("cannot be put in place: {}: check the folder", error.error)),
    })
}

/// Writes bytes to standard output.
pub fn write_to_stdout(bytes: &[u8]) -> Result<(), Failure> {
    out(bytes).map_err(|error| closed(&error))
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
