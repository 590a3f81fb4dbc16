//! `manifest.csv` in OUTDIR: a row for each mesh of the batch, from the start on, so that a batch can be gone on with.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::inputs::Input;
use super::spelled::{path_of, spelled};
use crate::failure::Failure;
use crate::files;
use crate::names::level_paths;
use neural_mesh::job::{Level, REACHED, Report};

/// The name of the file.
pub const NAME: &str = "manifest.csv";
/// Time between two writes while meshes are done: what is lost with a killed program is done again.
const PATIENCE: Duration = Duration::from_secs(1);
/// The outcome of a mesh that is not done yet.
const PENDING: &str = "pending";
/// How the outcome of a mesh that failed begins.
const FAILED: &str = "failed: ";

/// What became of a mesh.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Row {
    /// The mesh, by its path below the folder of all of them.
    name: String,
    /// The result, by its path below OUTDIR, with `{level}` for the number of a level of detail.
    output: String,
    vertices: Option<usize>,
    faces: Option<usize>,
    /// Of each level of detail, `;` between them.
    output_vertices: Option<String>,
    output_faces: Option<String>,
    /// Two-sided distance in percent of the diagonal, of each level.
    mean_percent: Option<String>,
    max_percent: Option<String>,
    /// From opening the mesh to the result on the disk.
    seconds: Option<f64>,
    /// `pending`, `reached`, `stopped: ` and why it is short of what was asked, or `failed: ` and why.
    outcome: String,
    /// What was asked of it.
    request: String,
}

impl Row {
    /// Rows of meshes that are not done yet.
    pub fn all(inputs: &[Input], outputs: &[PathBuf], request: &str) -> Vec<Self> {
        inputs.iter().zip(outputs).map(|(input, output)| Self::pending(input, output, request)).collect()
    }

    fn pending(input: &Input, output: &Path, request: &str) -> Self {
        Self {
            name: spelled(&input.below),
            output: spelled(output),
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

    /// Takes over what an earlier run came to; whether a file in the place of the result is that run's.
    fn go_on(&mut self, old: &Self, place: &Place, manifest: &Path) -> Result<bool, Failure> {
        if old.request != self.request {
            let what =
                format!("belongs to another batch ({}): use the same options, or choose another folder", old.request);
            return Err(Failure::of(manifest, what));
        }
        if old.is_done() && place.of(old).iter().all(|path| path.is_file()) {
            *self = old.clone();
        }
        // A row without an end: the file is of a run that was killed before it wrote the row. Of one that lacks a file the others are, too.
        Ok((old.outcome == PENDING || old.is_done()) && old.output == self.output)
    }

    fn fill(&mut self, done: Result<Report, Failure>, seconds: f64) {
        self.seconds = Some(seconds);
        match done {
            Err(failure) => self.outcome = format!("{FAILED}{failure}"),
            Ok(Report { input, output, outcome, distance, levels, .. }) => {
                (self.vertices, self.faces) = (Some(input.vertices), Some(input.faces));
                let level = Level::new(output, outcome, distance);
                let levels = if levels.is_empty() { vec![level] } else { levels };
                self.output_vertices = joined(levels.iter().map(|level| Some(level.output.size.vertices)));
                self.output_faces = joined(levels.iter().map(|level| Some(level.output.size.faces)));
                self.mean_percent = joined(levels.iter().map(|level| Some(level.distance?.mean_percent)));
                self.max_percent = joined(levels.iter().map(|level| Some(level.distance?.max_percent)));
                let short = levels.iter().map(|level| &level.outcome).find(|outcome| *outcome != REACHED);
                self.outcome = short.map_or(REACHED, String::as_str).into();
            }
        }
    }
}

/// A number for each level; none where one has none.
fn joined(numbers: impl Iterator<Item = Option<impl Serialize>>) -> Option<String> {
    let numbers: Option<Vec<_>> = numbers.map(|number| serde_json::to_string(&number?).ok()).collect();
    Some(numbers?.join(";"))
}

/// Where results stand.
pub struct Place {
    /// OUTDIR.
    pub folder: PathBuf,
    /// How many levels of detail are files of their own, if they are.
    pub n_levels: usize,
    /// Folders of what is told of each mesh, with the endings of its files.
    pub told: Vec<(PathBuf, &'static str)>,
}

impl Place {
    /// The files of a mesh.
    fn of(&self, row: &Row) -> Vec<PathBuf> {
        let told = self.told.iter().map(|(folder, ending)| folder.join(with_more(&path_of(&row.name), ending)));
        level_paths(&self.folder.join(path_of(&row.output)), self.n_levels).into_iter().chain(told).collect()
    }
}

/// `a/b.ply` and `.json`: `a/b.ply.json`.
pub fn with_more(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    name.push(ending);
    name.into()
}

/// How many meshes ended how.
pub struct Ends {
    pub reached: usize,
    pub stopped: usize,
    pub failed: usize,
}

/// The rows, in the memory and on the disk.
pub struct Manifest {
    path: PathBuf,
    place: Place,
    rows: Mutex<Rows>,
    /// Whether the result of a mesh may take the place of a file.
    may_replace: Vec<bool>,
    /// The meshes that are to be done.
    waiting: Vec<usize>,
}

struct Rows {
    rows: Vec<Row>,
    written: Instant,
}

impl Manifest {
    /// The rows of a new batch, or of one that goes on: then those that are done stay so.
    pub fn open(place: Place, mut rows: Vec<Row>, [resume, force]: [bool; 2]) -> Result<Self, Failure> {
        let path = place.folder.join(NAME);
        let known = if resume && path.exists() { read(&path)? } else { HashMap::new() };
        if !resume && !force {
            let outputs = rows.iter().flat_map(|row| place.of(row));
            refuse_existing(std::iter::once(path.clone()).chain(outputs))?;
        }
        let mut may_replace = vec![force; rows.len()];
        for (row, may_replace) in rows.iter_mut().zip(&mut may_replace) {
            if let Some(old) = known.get(&row.name) {
                *may_replace |= row.go_on(old, &place, &path)?;
            }
        }
        let waiting = (0..rows.len()).filter(|&i| rows[i].outcome == PENDING).collect();
        for (row, _) in rows.iter_mut().zip(&may_replace).filter(|(row, may)| row.outcome == PENDING && !**may) {
            if let Some(output) = place.of(row).into_iter().find(|path| path.symlink_metadata().is_ok()) {
                // It fails unless the file proves to be its result, which a run put there that did not come to its row.
                row.outcome = format!("{FAILED}{}", exists(&output));
            }
        }
        let manifest =
            Self { path, place, rows: Mutex::new(Rows { rows, written: Instant::now() }), may_replace, waiting };
        manifest.save()?;
        Ok(manifest)
    }

    /// Where the file stands.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The meshes that are to be done.
    pub fn waiting(&self) -> &[usize] {
        &self.waiting
    }

    /// What the meshes are called.
    pub fn names(&self) -> Vec<String> {
        self.held().rows.iter().map(|row| row.name.clone()).collect()
    }

    /// What the mesh is called.
    pub fn name(&self, i: usize) -> String {
        self.held().rows[i].name.clone()
    }

    /// The path of the result below OUTDIR.
    pub fn output(&self, i: usize) -> PathBuf {
        path_of(&self.held().rows[i].output)
    }

    /// Where results stand.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// The paths of all results below OUTDIR.
    pub fn outputs(&self) -> Vec<PathBuf> {
        let rows = &self.held().rows;
        rows.iter().flat_map(|row| level_paths(&path_of(&row.output), self.place.n_levels)).collect()
    }

    /// Whether the result may take the place of a file.
    pub fn may_replace(&self, i: usize) -> bool {
        self.may_replace[i]
    }

    /// A mesh is not to be done any more, as it fails.
    pub fn give_up(&mut self, i: usize, why: Failure) -> Result<(), Failure> {
        self.waiting.retain(|&waiting| waiting != i);
        self.set(i, Err(why), 0.0)
    }

    /// A mesh is done.
    pub fn set(&self, i: usize, done: Result<Report, Failure>, seconds: f64) -> Result<(), Failure> {
        let mut held = self.held();
        held.rows[i].fill(done, seconds);
        if held.written.elapsed() > PATIENCE { self.write(&mut held) } else { Ok(()) }
    }

    /// Writes all rows as they are.
    pub fn save(&self) -> Result<(), Failure> {
        self.write(&mut self.held())
    }

    /// How many meshes ended how.
    pub fn ends(&self) -> Ends {
        let rows = &self.held().rows;
        let count = |is: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| is(row)).count();
        let (reached, failed) = (count(&|row| row.outcome == REACHED), count(&|row| !row.is_done()));
        Ends { reached, failed, stopped: rows.len() - reached - failed }
    }

    fn write(&self, held: &mut Rows) -> Result<(), Failure> {
        let problem = |error: &dyn std::fmt::Display| Failure::of(&self.path, format!("cannot be written: {error}"));
        let mut writer = csv::Writer::from_writer(Vec::new());
        held.rows.iter().try_for_each(|row| writer.serialize(row)).map_err(|error| problem(&error))?;
        let bytes = writer.into_inner().map_err(|error| problem(&error))?;
        files::place(vec![files::prepare(&self.path, &bytes, true)?])?;
        held.written = Instant::now();
        Ok(())
    }

    fn held(&self) -> MutexGuard<'_, Rows> {
        self.rows.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The rows of an earlier run, by the names of their meshes.
fn read(path: &Path) -> Result<HashMap<String, Row>, Failure> {
    let problem = |error| Failure::of(path, format!("is not the manifest of a batch: {error}: choose another folder"));
    let rows = csv::Reader::from_path(path).map_err(problem)?.into_deserialize();
    rows.map(|row: Result<Row, csv::Error>| row.map(|row| (row.name.clone(), row)).map_err(problem)).collect()
}

fn refuse_existing(mut paths: impl Iterator<Item = PathBuf>) -> Result<(), Failure> {
    match paths.find(|path| path.symlink_metadata().is_ok()) {
        Some(path) => Err(exists(&path)),
        None => Ok(()),
    }
}

fn exists(path: &Path) -> Failure {
    Failure::of(path, "exists already: continue with --resume, replace with --force, or choose another folder")
}
