//! `manifest.csv` in OUTDIR: a row per mesh from the start, so that a batch can be resumed.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::inputs::{Input, join_names};
use crate::failure::Failure;
use crate::files;
use crate::names::level_paths;
use neural_mesh::io::FilesRead;
use neural_mesh::job::{JobReport, Level, REACHED};

pub const MANIFEST_FILE: &str = "manifest.csv";
/// Shortest time between two writes; a killed batch repeats meshes finished since the last one.
const WRITE_INTERVAL: Duration = Duration::from_secs(1);
const PENDING: &str = "pending";
const FAILED: &str = "failed: ";

#[derive(Clone, Debug, Default, Deserialize, Serialize)]
struct ManifestRow {
    /// Path relative to the common folder of all inputs.
    name: String,
    /// Path of the result in OUTDIR, with `{level}` for levels of detail.
    output: String,
    vertices: Option<usize>,
    faces: Option<usize>,
    /// Vertices of each level of detail, separated by `;`.
    output_vertices: Option<String>,
    output_faces: Option<String>,
    /// Mean two-sided distance of each level, in percent of the diagonal.
    mean_percent: Option<String>,
    max_percent: Option<String>,
    seconds: Option<f64>,
    /// `pending`, `reached`, or `stopped: ` or `failed: ` with the reason.
    outcome: String,
    request: String,
}

impl ManifestRow {
    fn is_done(&self) -> bool {
        self.outcome != PENDING && !self.outcome.starts_with(FAILED)
    }

    fn fill(&mut self, result: Result<JobReport, Failure>, seconds: f64) {
        self.seconds = Some(seconds);
        match result {
            Err(failure) => self.outcome = format!("{FAILED}{failure}"),
            Ok(JobReport { input, output, outcome, distance, levels, .. }) => {
                (self.vertices, self.faces) = (Some(input.vertices), Some(input.faces));
                let level = Level::new(output, outcome, distance);
                let levels = if levels.is_empty() { vec![level] } else { levels };
                self.output_vertices = join_numbers(levels.iter().map(|level| Some(level.output.size.vertices)));
                self.output_faces = join_numbers(levels.iter().map(|level| Some(level.output.size.faces)));
                self.mean_percent = join_numbers(levels.iter().map(|level| Some(level.distance?.mean_percent)));
                self.max_percent = join_numbers(levels.iter().map(|level| Some(level.distance?.max_percent)));
                let unmet = levels.iter().map(|level| &level.outcome).find(|outcome| *outcome != REACHED);
                self.outcome = unmet.map_or(REACHED, String::as_str).into();
            }
        }
    }
}

fn join_numbers(numbers: impl Iterator<Item = Option<impl Serialize>>) -> Option<String> {
    let numbers: Option<Vec<_>> = numbers.map(|number| serde_json::to_string(&number?).ok()).collect();
    Some(numbers?.join(";"))
}

pub struct BatchFolders {
    pub folder: PathBuf,
    /// Number of levels of detail written to separate files, or 0.
    pub n_levels: usize,
    /// Folders for reports and pictures, with the endings of their files.
    pub side_folders: Vec<(PathBuf, &'static str)>,
    /// Files that the batch reads: all meshes, weights and the list of names.
    pub read: FilesRead,
}

impl BatchFolders {
    /// Lists the files of a mesh: its results, report and picture.
    fn files_of_row(&self, row: &ManifestRow) -> Vec<PathBuf> {
        let side_file = |(folder, ending): &(PathBuf, _)| folder.join(format!("{}{ending}", row.name));
        let side_files = self.side_folders.iter().map(side_file);
        // A mesh that has fewer sizes than levels are requested has fewer files.
        let n_written =
            row.output_vertices.as_ref().filter(|_| row.is_done()).map(|numbers| numbers.split(';').count());
        let n_levels = n_written.map_or(self.n_levels, |n| n.min(self.n_levels));
        level_paths(&self.folder.join(&row.output), n_levels).into_iter().chain(side_files).collect()
    }
}

pub struct Manifest {
    pub path: PathBuf,
    pub folders: BatchFolders,
    /// Indices of the meshes without result.
    pub pending: Vec<usize>,
    /// True for each mesh whose existing files may be replaced.
    pub may_replace: Vec<bool>,
    /// Rows, and the time of their last write.
    rows: Mutex<(Vec<ManifestRow>, Instant)>,
}

impl Manifest {
    /// Creates the rows of a new batch, or continues those of an earlier run.
    pub fn open(
        folders: BatchFolders,
        inputs: &[Input],
        outputs: &[PathBuf],
        request: &str,
        [resume, force]: [bool; 2],
    ) -> Result<Self, Failure> {
        let path = folders.folder.join(MANIFEST_FILE);
        folders.read.check(&path, false).map_err(|error| Failure::in_file(&path, error))?;
        // Even --force replaces only the manifest of another batch, not any file of this name.
        let old_rows = if path.exists() && (resume || force) { read_rows(&path)? } else { HashMap::new() };
        let is_there = |path: &PathBuf| path.symlink_metadata().is_ok();
        let (mut rows, mut pending, mut may_replace) = (Vec::new(), Vec::new(), Vec::new());
        for (i, (input, output)) in inputs.iter().zip(outputs).enumerate() {
            let (outcome, output) = (PENDING.into(), join_names(output));
            let new = ManifestRow {
                name: input.name.clone(),
                output,
                outcome,
                request: request.into(),
                ..Default::default()
            };
            let old = old_rows.get(&new.name).filter(|_| resume);
            old.map_or(Ok(()), |old| check_request(old, request, &path))?;
            // A pending row may have files, if the run was killed before it wrote the row; they are then replaced. So are
            // the files of a done row if one of them is missing. Other files are replaced only with --force.
            let is_own = |old: &ManifestRow| (old.outcome == PENDING || old.is_done()) && old.output == new.output;
            may_replace.push(force || old.is_some_and(is_own));
            let is_complete =
                |old: &&ManifestRow| old.is_done() && folders.files_of_row(old).iter().all(|path| path.is_file());
            let mut row = old.filter(is_complete).cloned().unwrap_or(new);
            if row.outcome == PENDING {
                pending.push(i);
                let existing = || folders.files_of_row(&row).into_iter().find(is_there);
                if let Some(existing) = if may_replace[i] { None } else { existing() } {
                    // The mesh fails, unless the file turns out to be its result from a run that was killed before it
                    // wrote the row.
                    let failure = already_exists(&existing);
                    if !resume {
                        return Err(failure);
                    }
                    row.outcome = format!("{FAILED}{failure}");
                }
            }
            rows.push(row);
        }
        if !resume && !force && is_there(&path) {
            return Err(already_exists(&path));
        }
        let manifest = Self { path, folders, pending, may_replace, rows: Mutex::new((rows, Instant::now())) };
        manifest.save()?;
        Ok(manifest)
    }

    pub fn set_result(&self, i: usize, result: Result<JobReport, Failure>, seconds: f64) -> Result<(), Failure> {
        let mut locked = self.lock_rows();
        locked.0[i].fill(result, seconds);
        if locked.1.elapsed() > WRITE_INTERVAL { self.write(&mut locked) } else { Ok(()) }
    }

    pub fn save(&self) -> Result<(), Failure> {
        self.write(&mut self.lock_rows())
    }

    /// Returns how many meshes reached the target, stopped before it, and failed.
    pub fn count_outcomes(&self) -> [usize; 3] {
        let rows = &self.lock_rows().0;
        let reached = rows.iter().filter(|row| row.outcome == REACHED).count();
        let failed = rows.iter().filter(|row| !row.is_done()).count();
        [reached, rows.len() - reached - failed, failed]
    }

    fn write(&self, (rows, written): &mut (Vec<ManifestRow>, Instant)) -> Result<(), Failure> {
        let problem = |error: &dyn std::fmt::Display| {
            Failure::in_file(&self.path, format!("cannot be written: {error}: check the folder and the disk"))
        };
        let mut writer = csv::Writer::from_writer(Vec::new());
        rows.iter().try_for_each(|row| writer.serialize(row)).map_err(|error| problem(&error))?;
        let bytes = writer.into_inner().map_err(|error| problem(&error))?;
        files::place_files(vec![files::prepare_file(&self.path, &bytes, true)?], &self.folders.read)?;
        *written = Instant::now();
        Ok(())
    }

    fn lock_rows(&self) -> MutexGuard<'_, (Vec<ManifestRow>, Instant)> {
        self.rows.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn read_rows(path: &Path) -> Result<HashMap<String, ManifestRow>, Failure> {
    let problem =
        |error| Failure::in_file(path, format!("is not the manifest of a batch: {error}: choose another folder"));
    let mut reader = csv::Reader::from_path(path).map_err(problem)?;
    // A file without rows would pass as a manifest, whatever its first line is.
    if reader.headers().map_err(problem)?.get(0) != Some("name") {
        return Err(Failure::in_file(path, "is not the manifest of a batch: choose another folder"));
    }
    let rows = reader.into_deserialize();
    rows.map(|row: Result<ManifestRow, csv::Error>| row.map(|row| (row.name.clone(), row)).map_err(problem)).collect()
}

fn check_request(old: &ManifestRow, request: &str, manifest: &Path) -> Result<(), Failure> {
    if old.request == request {
        return Ok(());
    }
    let what = "use those options, start again with --force instead of --resume, or choose another folder";
    Err(Failure::in_file(manifest, format!("belongs to a batch with other options ({}): {what}", old.request)))
}

fn already_exists(path: &Path) -> Failure {
    Failure::in_file(path, "exists already: continue with --resume, replace with --force, or choose another folder")
}
