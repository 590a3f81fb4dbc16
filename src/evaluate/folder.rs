//! The folder of an evaluation: its settings beside its rows, so that only what was measured alike stands in one table.

use std::path::{Path, PathBuf};

use super::EvaluateError;
use super::rows_file::RowsFile;
use super::settings::Origin;
use crate::io::write_path;

/// How the names of files begin that belong to a run in progress.
const TEMPORARY: &str = ".neural-mesh-";

/// The table of rows.
pub(super) const ROWS: &str = "rows.csv";
/// What the rows were measured with.
pub(super) const SETTINGS: &str = "settings.json";

/// Opens the folder for more rows: makes it, or takes it up again where `resume` and all is as it was.
pub(super) fn open_folder(
    folder: &Path,
    origin: &Origin,
    resume: bool,
    figures: &[String],
) -> Result<RowsFile, EvaluateError> {
    let settings = folder.join(SETTINGS);
    if settings.exists() {
        if !resume {
            let what = "holds an evaluation already: continue with --resume, or choose another folder";
            return Err(EvaluateError::file(folder, what));
        }
        if let Some(difference) = read_origin(&settings)?.difference(origin) {
            return Err(EvaluateError::Differs(difference));
        }
    } else {
        check_is_empty(folder)?;
        let problem = |error| EvaluateError::file(folder, format!("cannot be created: {error}: choose another folder"));
        std::fs::create_dir_all(folder).map_err(problem)?;
        let text = serde_json::to_string_pretty(origin).map_err(|error| EvaluateError::file(&settings, error))?;
        write_whole(&settings, &(text + "\n"))?;
    }
    let rows = RowsFile::open(&folder.join(ROWS), figures)?;
    remove_leftovers(folder);
    Ok(rows)
}

fn read_origin(path: &Path) -> Result<Origin, EvaluateError> {
    let broken = |what: String| EvaluateError::file(path, format!("{what}: put the file back or start over"));
    let text = std::fs::read_to_string(path).map_err(|error| broken(format!("cannot be read: {error}")))?;
    serde_json::from_str(&text).map_err(|error| broken(error.to_string()))
}

/// Writes a file of the folder, whole or not at all.
pub(super) fn write_whole(path: &Path, text: &str) -> Result<(), EvaluateError> {
    write_path(path, text.as_bytes(), true).map_err(|error| EvaluateError::file(path, error))
}

/// A folder for what is only needed while methods run; it goes when dropped.
pub(super) fn scratch_in(folder: &Path) -> Result<tempfile::TempDir, EvaluateError> {
    let made = tempfile::Builder::new().prefix(TEMPORARY).tempdir_in(folder);
    made.map_err(|error| EvaluateError::file(folder, format!("cannot be written to: {error}: check the disk")))
}

/// Refuses a folder that holds anything but what a killed run was just writing.
fn check_is_empty(folder: &Path) -> Result<(), EvaluateError> {
    let other = entries(folder).into_iter().find(|path| !is_temporary(path));
    other.map_or(Ok(()), |path| {
        let name = path.file_name().unwrap_or_default().display();
        let what = format!("holds {name} but no evaluation: choose another folder or empty it");
        Err(EvaluateError::file(folder, what))
    })
}

/// Removes what a killed run has left.
fn remove_leftovers(folder: &Path) {
    for path in entries(folder).into_iter().filter(|path| is_temporary(path)) {
        // What cannot be removed takes room, nothing else.
        let _ = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
    }
}

fn is_temporary(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(TEMPORARY))
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    std::fs::read_dir(folder).map(|entries| entries.flatten().map(|entry| entry.path()).collect()).unwrap_or_default()
}
