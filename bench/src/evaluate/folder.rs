//! The folder of an evaluation.

use std::path::{Path, PathBuf};

use super::rows_file::{RowsFile, read_rows};
use super::settings::Origin;
use super::{EvaluateError, ResultRow, Table, Tool};
use neural_mesh::io::write_path;

const TEMPORARY: &str = ".neural-mesh-";

pub(super) const ROWS: &str = "rows.csv";
pub(super) const SETTINGS: &str = "settings.json";

pub(super) struct FolderState {
    pub table: Table,
    holds_evaluation: bool,
    // Tools whose command differs from that of the earlier run, with the earlier command; none of them has a result.
    corrected: Vec<Tool>,
}

impl FolderState {
    fn is_outdated(&self, row: &ResultRow) -> bool {
        // A row of an unreadable mesh stays, since another command would not change it.
        row.vertices_in > 0 && self.corrected.iter().any(|tool| tool.name == row.method)
    }
}

/// Reads a folder and checks that it is empty, or that `resume` is set and all settings agree.
///
/// Commands of tools without a result may differ.
pub(super) fn inspect_folder(folder: &Path, origin: &Origin, resume: bool) -> Result<FolderState, EvaluateError> {
    let settings = folder.join(SETTINGS);
    let mut found = FolderState { table: Table::default(), holds_evaluation: settings.exists(), corrected: Vec::new() };
    if !found.holds_evaluation {
        return check_is_empty(folder).map(|()| found);
    }
    if !resume {
        let what = "already contains an evaluation: continue with --resume, or choose another folder";
        return Err(EvaluateError::file(folder, what));
    }
    let (before, corrected) = read_origin(&settings)?.with_commands_of(origin);
    if let Some(difference) = before.difference(origin) {
        return Err(EvaluateError::Differs(difference));
    }
    found.corrected = corrected;
    let rows = folder.join(ROWS);
    if rows.exists() {
        found.table = read_rows(&rows)?;
    }
    check_failed(&found.corrected, &found.table)?;
    let mut table = std::mem::take(&mut found.table);
    table.rows.retain(|row| !found.is_outdated(row));
    Ok(FolderState { table, ..found })
}

fn check_failed(corrected: &[Tool], table: &Table) -> Result<(), EvaluateError> {
    let has_result = |tool: &&Tool| table.rows.iter().any(|row| row.method == tool.name && row.error.is_empty());
    corrected.iter().find(has_result).map_or(Ok(()), |Tool { name, command }| {
        Err(EvaluateError::Differs(format!("the tool {name} already has results of another command, `{command}`")))
    })
}

pub(super) fn open_folder(
    folder: &Path,
    origin: &Origin,
    found: &FolderState,
    figures: &[String],
) -> Result<RowsFile, EvaluateError> {
    let settings = folder.join(SETTINGS);
    if !found.holds_evaluation {
        let problem = |error| EvaluateError::file(folder, format!("cannot be created: {error}: choose another folder"));
        std::fs::create_dir_all(folder).map_err(problem)?;
        write_origin(&settings, origin)?;
    }
    let mut rows = RowsFile::open(&folder.join(ROWS), figures)?;
    remove_leftovers(folder);
    // Rows of a corrected tool are removed only if the locked table still has no result of it.
    if !found.corrected.is_empty() {
        check_failed(&found.corrected, &rows.table)?;
        rows.remove(|row| found.is_outdated(row))?;
        write_origin(&settings, origin)?;
    }
    Ok(rows)
}

fn write_origin(path: &Path, origin: &Origin) -> Result<(), EvaluateError> {
    let text = serde_json::to_string_pretty(origin).map_err(|error| EvaluateError::file(path, error))?;
    write_whole(path, &(text + "\n"))
}

fn read_origin(path: &Path) -> Result<Origin, EvaluateError> {
    let broken = |what: String| {
        EvaluateError::file(path, format!("{what}: put a good copy of the file back, or choose another folder"))
    };
    let text = std::fs::read_to_string(path).map_err(|error| broken(format!("cannot be read: {error}")))?;
    serde_json::from_str(&text).map_err(|error| broken(error.to_string()))
}

pub(super) fn write_whole(path: &Path, text: &str) -> Result<(), EvaluateError> {
    write_path(path, text.as_bytes(), true).map_err(|error| EvaluateError::file(path, error))
}

pub(super) fn scratch_in(folder: &Path) -> Result<tempfile::TempDir, EvaluateError> {
    let made = tempfile::Builder::new().prefix(TEMPORARY).tempdir_in(folder);
    made.map_err(|error| EvaluateError::file(folder, format!("cannot be written to: {error}: check the disk")))
}

fn check_is_empty(folder: &Path) -> Result<(), EvaluateError> {
    let other = entries(folder).into_iter().find(|path| !is_temporary(path));
    other.map_or(Ok(()), |path| {
        let name = path.file_name().unwrap_or_default().display();
        let what = format!(
            "contains {name}, but no evaluation; a new one needs an empty folder: empty this one, or choose another"
        );
        Err(EvaluateError::file(folder, what))
    })
}

fn remove_leftovers(folder: &Path) {
    for path in entries(folder).into_iter().filter(|path| is_temporary(path)) {
        // A leftover that cannot be removed does no harm.
        let _ = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
    }
}

fn is_temporary(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(TEMPORARY))
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    std::fs::read_dir(folder).map(|entries| entries.flatten().map(|entry| entry.path()).collect()).unwrap_or_default()
}
