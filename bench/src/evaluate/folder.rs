//! The folder of an evaluation.

use std::path::{Path, PathBuf};

use super::settings::Origin;
use crate::rows_file::{RowsFile, differs};
use neural_mesh::io::write_path;
use neural_mesh_cli::shared::Failure;

const TEMPORARY: &str = ".neural-mesh-";

pub(super) const ROWS: &str = "rows.csv";
const SETTINGS: &str = "settings.json";

/// Opens the rows of a folder that is empty, or whose settings agree if `resume` is set.
pub(super) fn open_folder(
    folder: &Path,
    origin: &Origin,
    resume: bool,
    figures: &[String],
) -> Result<RowsFile, Failure> {
    let settings = folder.join(SETTINGS);
    if !settings.exists() {
        check_is_empty(folder)?;
        let problem = |error| Failure::in_file(folder, format!("cannot be created: {error}: choose another folder"));
        std::fs::create_dir_all(folder).map_err(problem)?;
        let text = serde_json::to_string_pretty(origin).map_err(|error| Failure::in_file(&settings, error))?;
        write_whole(&settings, &(text + "\n"))?;
    } else if !resume {
        let what = "already contains an evaluation: continue with --resume, or choose another folder";
        return Err(Failure::in_file(folder, what));
    } else if let Some(difference) = read_origin(&settings)?.difference(origin) {
        return Err(differs(&difference));
    }
    let rows = RowsFile::open(&folder.join(ROWS), figures)?;
    // Only the holder of the lock removes what a killed run left.
    remove_leftovers(folder);
    Ok(rows)
}

fn read_origin(path: &Path) -> Result<Origin, Failure> {
    let broken = |what: String| {
        Failure::in_file(path, format!("{what}: put a good copy of the file back, or choose another folder"))
    };
    let text = std::fs::read_to_string(path).map_err(|error| broken(format!("cannot be read: {error}")))?;
    serde_json::from_str(&text).map_err(|error| broken(error.to_string()))
}

pub(super) fn write_whole(path: &Path, text: &str) -> Result<(), Failure> {
    write_path(path, text.as_bytes(), true).map_err(|error| Failure::in_file(path, error))
}

pub(super) fn scratch_in(folder: &Path) -> Result<tempfile::TempDir, Failure> {
    let made = tempfile::Builder::new().prefix(TEMPORARY).tempdir_in(folder);
    made.map_err(|error| Failure::in_file(folder, format!("cannot be written to: {error}: check the disk")))
}

fn check_is_empty(folder: &Path) -> Result<(), Failure> {
    let other = entries(folder).into_iter().find(|path| !is_temporary(path));
    other.map_or(Ok(()), |path| {
        let name = path.file_name().unwrap_or_default().display();
        let what = format!(
            "contains {name}, but no evaluation; a new one needs an empty folder: empty this one, or choose another"
        );
        Err(Failure::in_file(folder, what))
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
