//! Files and standard streams; files appear complete or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use neural_mesh::io::{self, FilesRead};
use serde::Serialize;
use tempfile::NamedTempFile;

use crate::escapes::escape_controls_in_json;
use crate::failure::Failure;
use crate::interrupt;
use crate::messages::{stdout_failure, write_stdout};
use crate::names::is_stream;

pub use crate::content::read;

const MAX_LINKS: usize = 40;

/// Result in a temporary file, to be moved into place.
pub struct PendingFile {
    temporary: NamedTempFile,
    name: PathBuf,
    destination: PathBuf,
    force: bool,
}

impl PendingFile {
    /// Returns whether this file will be moved to `path`.
    pub fn is_at(&self, path: &Path) -> bool {
        self.destination == path
    }

    fn is_already_placed(&self) -> bool {
        let existing = std::fs::read(&self.destination).ok();
        !self.force && existing.is_some() && existing == std::fs::read(self.temporary.path()).ok()
    }
}

/// Files that a run will write.
#[derive(Default)]
pub struct OutputPaths {
    /// Results, which may replace the mesh that was read.
    pub results: Vec<PathBuf>,
    /// Reports, pictures, pages and others, which replace nothing that was read.
    pub others: Vec<PathBuf>,
}

impl OutputPaths {
    /// Collects paths, without standard output.
    pub fn new<'a>(
        results: impl IntoIterator<Item = &'a PathBuf>,
        others: impl IntoIterator<Item = &'a PathBuf>,
    ) -> Self {
        let is_file = |path: &&PathBuf| !is_stream(path);
        let [results, others] = [
            results.into_iter().filter(is_file).cloned().collect(),
            others.into_iter().filter(is_file).cloned().collect(),
        ];
        Self { results, others }
    }
}

/// Lists the files that a run reads besides its mesh.
pub fn list_files_read<'a>(mesh: Option<&Path>, others: impl IntoIterator<Item = &'a Path>) -> FilesRead {
    let read = mesh.map_or_else(FilesRead::default, |path| match open_stdin(path) {
        Some(stdin) => FilesRead::from_open_mesh(&stdin),
        None => FilesRead::from_mesh_path(path),
    });
    for path in others {
        match open_stdin(path) {
            Some(stdin) => read.add_open(&stdin),
            None => read.add(path),
        }
    }
    read
}

/// Returns standard input as an open file, if the path means it.
fn open_stdin(path: &Path) -> Option<std::fs::File> {
    #[cfg(unix)]
    use std::os::fd::AsFd as AsOpen;
    #[cfg(windows)]
    use std::os::windows::io::AsHandle as AsOpen;
    if !is_stream(path) {
        return None;
    }
    #[cfg(unix)]
    let open = AsOpen::as_fd(&std::io::stdin()).try_clone_to_owned();
    #[cfg(windows)]
    let open = AsOpen::as_handle(&std::io::stdin()).try_clone_to_owned();
    open.ok().map(std::fs::File::from)
}

/// Rejects output paths of files that are read, of which two lead to one file, or where no file can be written.
pub fn check_output_paths(paths: &OutputPaths, read: &FilesRead, force: bool) -> Result<(), Failure> {
    let OutputPaths { results, others } = paths;
    let marked = results.iter().map(|path| (path, true)).chain(others.iter().map(|path| (path, false)));
    for (path, is_result) in marked {
        // This comes first, since --force does not help.
        read.check(path, is_result).map_err(|error| Failure::in_file(path, error))?;
    }
    let paths: Vec<&PathBuf> = results.iter().chain(others).collect();
    let mut destinations = Vec::new();
    for path in &paths {
        let destination = resolve_links(path)?;
        // Links are resolved here, since two names may lead to one file.
        if destinations.contains(&destination) {
            let what = format!("{}: is the file of two results: give each result its own file", path.display());
            return Err(Failure::Usage(what));
        }
        destinations.push(destination);
    }
    paths.into_iter().try_for_each(|path| check_output_path(path, force))
}

/// Rejects a path where no file can be written or an existing one may not be replaced.
fn check_output_path(path: &Path, force: bool) -> Result<(), Failure> {
    let destination = resolve_links(path)?;
    let folder = folder_of(&destination);
    if !folder.is_dir() {
        return Err(Failure::in_file(path, format!("there is no folder {}: create it first", folder.display())));
    }
    match std::fs::symlink_metadata(path) {
        Err(_) => {}
        Ok(_) if !force => return Err(already_exists(path)),
        // A link may lead to a file that does not exist yet; folders and devices are never replaced.
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
    create_temporary_in(folder).map(drop).map_err(unwritable)
}

/// Returns the file behind links, so that links stay and their targets are replaced.
fn resolve_links(path: &Path) -> Result<PathBuf, Failure> {
    let mut destination = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        let Ok(next) = std::fs::read_link(&destination) else { return Ok(resolve_folder(&destination)) };
        destination = folder_of(&destination).join(next);
    }
    Err(Failure::in_file(path, "is a link that never ends: choose another name"))
}

pub fn resolve_folder(path: &Path) -> PathBuf {
    let folder = std::fs::canonicalize(folder_of(path));
    match (folder, path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_path_buf(),
    }
}

/// Writes bytes to a temporary file in the final folder, compressed for names in `.gz`.
pub fn prepare_file(name: &Path, bytes: &[u8], force: bool) -> Result<PendingFile, Failure> {
    let bytes = io::compress_by_name(name, bytes).map_err(|error| Failure::in_file(name, error))?;
    let (pending, ()) = prepare_file_by(name, force, |file| file.write_all(&bytes))?;
    Ok(pending)
}

/// Lets `write` fill a temporary file in the final folder; also returns what it returns.
pub fn prepare_file_by<T>(
    name: &Path,
    force: bool,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<T>,
) -> Result<(PendingFile, T), Failure> {
    let destination = resolve_links(name)?;
    let problem = |error| Failure::in_file(name, format!("cannot be written: {error}: check the folder and the disk"));
    // The temporary file is in the final folder, so that moving it into place is a rename.
    let mut temporary = create_temporary_in(folder_of(&destination)).map_err(problem)?;
    let written = write(&mut temporary).map_err(problem)?;
    Ok((PendingFile { temporary, name: name.into(), destination, force }, written))
}

/// Prepares the file of a JSON document; for standard output, returns the document's bytes instead.
pub fn prepare_json(
    path: Option<&Path>,
    value: &impl Serialize,
    force: bool,
    pending: &mut Vec<PendingFile>,
) -> Result<Option<Vec<u8>>, Failure> {
    let Some(path) = path else { return Ok(None) };
    let json = serde_json::to_string_pretty(value).map_err(|error| Failure::in_file(path, error))? + "\n";
    if is_stream(path) {
        return Ok(Some(escape_controls_in_json(&json).into_bytes()));
    }
    pending.push(prepare_file(path, json.as_bytes(), force)?);
    Ok(None)
}

/// Moves all results into place, unless one would replace a file that was read; an interruption waits for it.
pub fn place_files(pending: Vec<PendingFile>, read: &FilesRead) -> Result<(), Failure> {
    check_pending(&pending, read)?;
    interrupt::without_interruption(|| pending.into_iter().try_for_each(|file| place_file(file, read)))
}

/// Moves results into place; accepts an identical file of an earlier run.
pub fn place_missing_files(pending: Vec<PendingFile>, read: &FilesRead) -> Result<(), Failure> {
    place_files(pending.into_iter().filter(|pending| !pending.is_already_placed()).collect(), read)
}

/// Rejects files that would replace one that was read, by names that were unknown before the mesh was read.
pub fn check_pending(pending: &[PendingFile], read: &FilesRead) -> Result<(), Failure> {
    let check = |file: &PendingFile| read.check(&file.name, true).map_err(|error| Failure::in_file(&file.name, error));
    pending.iter().try_for_each(check)
}

fn place_file(pending: PendingFile, read: &FilesRead) -> Result<(), Failure> {
    let PendingFile { temporary, name, destination, force } = pending;
    read.forget_mesh(&destination);
    // Another program may have created the file meanwhile; only --force replaces it.
    let placed = if force { temporary.persist(&destination) } else { temporary.persist_noclobber(&destination) };
    placed.map(drop).map_err(|error| match error.error.kind() {
        std::io::ErrorKind::AlreadyExists => already_exists(&name),
        _ => Failure::in_file(
            &name,
            format!("cannot be renamed from its temporary name: {}: check the folder", error.error),
        ),
    })
}

pub fn write_to_stdout(bytes: &[u8]) -> Result<(), Failure> {
    write_stdout(bytes).map_err(|error| stdout_failure(&error))
}

fn already_exists(path: &Path) -> Failure {
    Failure::in_file(path, "exists already: choose another name, or replace it with --force")
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Returns whether names in a folder that differ only by case are of one file, also where no file can be made.
pub fn ignores_case(folder: &Path) -> bool {
    let Ok(file) = create_temporary_in(folder) else { return true };
    folder.join(file.path().file_name().unwrap_or_default().to_ascii_uppercase()).exists()
}

/// Creates a temporary file with the permissions of an ordinary one.
fn create_temporary_in(folder: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".neural-mesh-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The default of the crate is private to the owner.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    interrupt::register_temporary(|| builder.tempfile_in(folder))
}
