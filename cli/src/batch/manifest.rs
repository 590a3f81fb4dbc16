//! `manifest.csv` in OUTDIR: a row per mesh from the start, so that a batch can be resumed.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::inputs::Input;
use super::path_text::{parse_path, spell_path};
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

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct ManifestRow {
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
    pub fn create_all(inputs: &[Input], outputs: &[PathBuf], request: &str) -> Vec<Self> {
        inputs.iter().zip(outputs).map(|(input, output)| Self::pending(input, output, request)).collect()
    }

    fn pending(input: &Input, output: &Path, request: &str) -> Self {
        Self {
            name: spell_path(&input.relative_path),
            output: spell_path(output),
            vertices: None,
            faces: None,
            output_vertices: None,
            output_faces: None,
            mean_percent: None,
            max_percent: None,
            seconds: None,
            outcome: PENDING.into(),
            request: request.into(),
        }
    }

    fn is_done(&self) -> bool {
        self.outcome != PENDING && !self.outcome.starts_with(FAILED)
    }

    /// Takes over the result of an earlier run; returns whether existing result files belong to that run.
    fn resume_from(&mut self, old: &Self, folders: &BatchFolders, manifest: &Path) -> Result<bool, Failure> {
        if old.request != self.request {
            let what = format!(
                "belongs to a batch with other options ({}): use those options, start again with --force instead of --resume, or choose another folder",
                old.request
            );
            return Err(Failure::in_file(manifest, what));
        }
        if old.is_done() && folders.files_of_row(old).iter().all(|path| path.is_file()) {
            *self = old.clone();
        }
        // A pending row may have files, if the run was killed before it wrote the row; they are then replaced. So are
        // the files of a done row if one of them is missing.
        Ok((old.outcome == PENDING || old.is_done()) && old.output == self.output)
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
    fn files_of_row(&self, row: &ManifestRow) -> Vec<PathBuf> {
        let side_files =
            self.side_folders.iter().map(|(folder, ending)| folder.join(append_ending(&parse_path(&row.name), ending)));
        level_paths(&self.folder.join(parse_path(&row.output)), self.n_levels).into_iter().chain(side_files).collect()
    }
}

/// Appends an ending to the whole name: `a/b.ply` and `.json` give `a/b.ply.json`.
pub fn append_ending(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    name.push(ending);
    name.into()
}

pub struct OutcomeCounts {
    pub reached: usize,
    pub stopped: usize,
    pub failed: usize,
}

pub struct Manifest {
    path: PathBuf,
    folders: BatchFolders,
    rows: Mutex<Rows>,
    may_replace: Vec<bool>,
    pending_meshes: Vec<usize>,
}

struct Rows {
    rows: Vec<ManifestRow>,
    written: Instant,
}

impl Manifest {
    /// Creates the rows of a new batch, or continues those of an earlier run.
    pub fn open(
        folders: BatchFolders,
        mut rows: Vec<ManifestRow>,
        [resume, force]: [bool; 2],
    ) -> Result<Self, Failure> {
        let path = folders.folder.join(MANIFEST_FILE);
        folders.read.check(&path, false).map_err(|error| Failure::in_file(&path, error))?;
        // Even --force replaces only the manifest of another batch, not any file of this name.
        let old_rows = if path.exists() && (resume || force) { read_rows(&path)? } else { HashMap::new() };
        let old_rows = if resume { old_rows } else { HashMap::new() };
        if !resume && !force {
            let outputs = rows.iter().flat_map(|row| folders.files_of_row(row));
            refuse_existing(std::iter::once(path.clone()).chain(outputs))?;
        }
        // Files of an earlier run of this batch may be replaced, other files only with --force.
        let mut may_replace = vec![force; rows.len()];
        for (row, may_replace) in rows.iter_mut().zip(&mut may_replace) {
            if let Some(old) = old_rows.get(&row.name) {
                *may_replace |= row.resume_from(old, &folders, &path)?;
            }
        }
        let pending_meshes = (0..rows.len()).filter(|&i| rows[i].outcome == PENDING).collect();
        for (row, _) in rows.iter_mut().zip(&may_replace).filter(|(row, may)| row.outcome == PENDING && !**may) {
            if let Some(output) = folders.files_of_row(row).into_iter().find(|path| path.symlink_metadata().is_ok()) {
                // The mesh fails, unless the file turns out to be its result from a run that was killed before it wrote
                // the row.
                row.outcome = format!("{FAILED}{}", already_exists(&output));
            }
        }
        let manifest = Self {
            path,
            folders,
            rows: Mutex::new(Rows { rows, written: Instant::now() }),
            may_replace,
            pending_meshes,
        };
        manifest.save()?;
        Ok(manifest)
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn pending_meshes(&self) -> &[usize] {
        &self.pending_meshes
    }

    pub fn names(&self) -> Vec<String> {
        self.lock_rows().rows.iter().map(|row| row.name.clone()).collect()
    }

    pub fn name(&self, i: usize) -> String {
        self.lock_rows().rows[i].name.clone()
    }

    pub fn output(&self, i: usize) -> PathBuf {
        parse_path(&self.lock_rows().rows[i].output)
    }

    pub fn folders(&self) -> &BatchFolders {
        &self.folders
    }

    pub fn outputs(&self) -> Vec<PathBuf> {
        let rows = &self.lock_rows().rows;
        rows.iter().flat_map(|row| level_paths(&parse_path(&row.output), self.folders.n_levels)).collect()
    }

    pub fn may_replace(&self, i: usize) -> bool {
        self.may_replace[i]
    }

    pub fn fail_mesh(&mut self, i: usize, why: Failure) -> Result<(), Failure> {
        self.pending_meshes.retain(|&pending_meshes| pending_meshes != i);
        self.set_result(i, Err(why), 0.0)
    }

    pub fn set_result(&self, i: usize, result: Result<JobReport, Failure>, seconds: f64) -> Result<(), Failure> {
        let mut locked = self.lock_rows();
        locked.rows[i].fill(result, seconds);
        if locked.written.elapsed() > WRITE_INTERVAL { self.write(&mut locked) } else { Ok(()) }
    }

    pub fn save(&self) -> Result<(), Failure> {
        self.write(&mut self.lock_rows())
    }

    pub fn count_outcomes(&self) -> OutcomeCounts {
        let rows = &self.lock_rows().rows;
        let count = |is: &dyn Fn(&ManifestRow) -> bool| rows.iter().filter(|row| is(row)).count();
        let (reached, failed) = (count(&|row| row.outcome == REACHED), count(&|row| !row.is_done()));
        OutcomeCounts { reached, failed, stopped: rows.len() - reached - failed }
    }

    fn write(&self, locked: &mut Rows) -> Result<(), Failure> {
        let problem = |error: &dyn std::fmt::Display| {
            Failure::in_file(&self.path, format!("cannot be written: {error}: check the folder and the disk"))
        };
        let mut writer = csv::Writer::from_writer(Vec::new());
        locked.rows.iter().try_for_each(|row| writer.serialize(row)).map_err(|error| problem(&error))?;
        let bytes = writer.into_inner().map_err(|error| problem(&error))?;
        files::place_files(vec![files::prepare_file(&self.path, &bytes, true)?], &self.folders.read)?;
        locked.written = Instant::now();
        Ok(())
    }

    fn lock_rows(&self) -> MutexGuard<'_, Rows> {
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

fn refuse_existing(mut paths: impl Iterator<Item = PathBuf>) -> Result<(), Failure> {
    match paths.find(|path| path.symlink_metadata().is_ok()) {
        Some(path) => Err(already_exists(&path)),
        None => Ok(()),
    }
}

fn already_exists(path: &Path) -> Failure {
    Failure::in_file(path, "exists already: continue with --resume, replace with --force, or choose another folder")
}
