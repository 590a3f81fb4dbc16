//! An evaluation from beginning to end.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rayon::prelude::*;

use super::contest::{ContestCase, MethodOutcome, run_case};
use super::engine::{Engine, TimedScope, Worker};
use super::folder::{open_folder, scratch_in};
use super::meshes::{MeshFile, checksums, mesh_files, read_mesh};
use super::method::Method;
use super::settings::{LearnedFile, Origin, Settings, learned_files, learned_names, weights_name};
use crate::along_surface::{IntrinsicOptions, Judge};
use crate::error::EvaluateError;
use crate::rows::{ResultRow, Table, median};
use crate::rows_file::RowsFile;
use neural_mesh::appearance::{self, USUAL_HEIGHT, appearance};
use neural_mesh::mesh::{TriMesh, shapes};
use neural_mesh::metrics::{CompareOptions, Figure};
use neural_mesh::model::Weights;

// Figures before those of the judge; `whole_process` is 1 if a tool's time includes start, reading and writing.
const SIZES: [&str; 9] = [
    "vertices_in",
    "faces_in",
    "vertices_asked",
    "faces_asked",
    "vertices_out",
    "faces_out",
    "seconds",
    "runs",
    "whole_process",
];

/// Input of an evaluation.
#[derive(Clone, Debug)]
pub struct Request {
    /// Folder of the meshes.
    pub data: PathBuf,
    /// Folder of the output, created if missing.
    pub folder: PathBuf,
    /// Settings.
    pub settings: Settings,
    /// Weights of the closed assembly; the shipped ones if `None`.
    pub weights: Option<PathBuf>,
    /// Weights of the paper's assembly; the shipped ones if `None`.
    pub paper_weights: Option<PathBuf>,
    /// Weights of learned baselines; the others use shipped ones.
    pub learned_weights: Vec<PathBuf>,
    /// True to continue with the present rows.
    pub resume: bool,
    /// Process that runs one method at a time.
    pub worker: Worker,
}

impl Request {
    /// Makes a request with default settings.
    pub fn new(data: impl Into<PathBuf>, folder: impl Into<PathBuf>, worker: Worker) -> Self {
        Self {
            data: data.into(),
            folder: folder.into(),
            settings: Settings::default(),
            weights: None,
            paper_weights: None,
            learned_weights: Vec::new(),
            resume: false,
            worker,
        }
    }
}

/// An event during an evaluation.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// A case begins.
    Case {
        /// Mesh file.
        mesh: &'a str,
        /// Target ratio of vertices.
        ratio: f64,
        /// Random seed.
        seed: u64,
        /// Number of cases done, earlier runs included.
        n_done: usize,
        /// Number of all cases.
        n_cases: usize,
    },
    /// A method runs; reported repeatedly.
    Running {
        /// Running method.
        method: &'a Method,
        /// Index of this method's run in the case, from 0.
        round: usize,
    },
    /// Results are being measured.
    Judging,
    /// A row was added.
    Row(&'a ResultRow),
}

/// The way an evaluation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// All rows are there.
    Finished,
    /// The caller stopped it; finished rows are saved.
    Stopped,
}

/// Measures every method at every ratio on every mesh and appends the rows to `rows.csv` case by case.
///
/// A killed run loses only the present case. `report` can stop the run by `Break`.
///
/// # Errors
/// [`EvaluateError`] about settings, data or folder.
pub fn evaluate(request: &Request, report: &mut dyn FnMut(Event) -> ControlFlow<()>) -> Result<Ending, EvaluateError> {
    let methods = request.settings.resolve_methods()?;
    let files = mesh_files(&request.data, &request.settings.only)?;
    let learned = learned_files(&request.learned_weights)?;
    let origin = Origin {
        version: env!("CARGO_PKG_VERSION").into(),
        settings: request.settings.clone(),
        weights: [
            weights_name(request.weights.as_ref(), Weights::shipped_default())?,
            weights_name(request.paper_weights.as_ref(), Weights::shipped_paper_open())?,
        ],
        learned: learned_names(&learned),
        meshes: checksums(&files),
    };
    let judged = empty_figures().into_iter().map(|figure| figure.name);
    let figures: Vec<String> = SIZES.into_iter().chain(judged).map(String::from).collect();
    let rows = open_folder(&request.folder, &origin, request.resume, &figures)?;
    let scratch = scratch_in(&request.folder)?;
    let (n_figures, scratch) = (figures.len(), scratch.path());
    let mut run = EvaluationRun { request, methods, learned, rows, n_figures, scratch, machine: machine() };
    for (index, file) in files.iter().enumerate() {
        if run.run_mesh(file, index, files.len(), report)?.is_break() {
            return Ok(Ending::Stopped);
        }
    }
    Ok(Ending::Finished)
}

fn machine() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let model = model.map_or(std::env::consts::ARCH, |(_, name)| name.trim());
    format!("{model}, {} cores", std::thread::available_parallelism().map_or(1, usize::from))
}

fn empty_figures() -> Vec<Figure> {
    let mesh = shapes::icosphere(0);
    let mut judging = CompareOptions::default();
    judging.samples = 1;
    all_figures(&Judge::new(&mesh, &judging, &IntrinsicOptions::NONE), &mesh, 0, None)
}

fn all_figures(judge: &Judge, result: &TriMesh, n_asked: usize, seen_beside: Option<&TriMesh>) -> Vec<Figure> {
    let mut figures = judge.figures(result, n_asked);
    // The size has its own columns.
    figures.retain(|figure| !["vertices", "faces"].contains(&figure.name));
    let looks = seen_beside.and_then(|original| appearance(original, result, USUAL_HEIGHT));
    figures.extend(appearance::figures(looks.as_ref()));
    figures
}

struct PreparedMesh {
    mesh: TriMesh,
    judge: Judge,
}

struct EvaluationRun<'a> {
    request: &'a Request,
    methods: Vec<Method>,
    learned: Vec<LearnedFile>,
    rows: RowsFile,
    n_figures: usize,
    scratch: &'a Path,
    machine: String,
}

struct Trial<'a> {
    mesh: &'a str,
    ratio: f64,
    seed: u64,
}

impl Trial<'_> {
    fn row<'a>(&self, table: &'a Table, method: &Method) -> Option<&'a ResultRow> {
        table.rows.iter().find(|row| row.is_case(self.mesh, self.ratio, self.seed, method.name()))
    }
}

impl EvaluationRun<'_> {
    fn run_mesh(
        &mut self,
        file: &MeshFile,
        index: usize,
        n_files: usize,
        report: &mut dyn FnMut(Event) -> ControlFlow<()>,
    ) -> Result<ControlFlow<()>, EvaluateError> {
        let Settings { ratios, seeds, .. } = &self.request.settings;
        let mesh = &file.name;
        let cases: Vec<Trial> =
            ratios.iter().flat_map(|&ratio| seeds.iter().map(move |&seed| Trial { mesh, ratio, seed })).collect();
        let n_cases = cases.len();
        let mut ready = None;
        for (at, trial) in cases.iter().enumerate() {
            let is_missing = |method: &&Method| trial.row(&self.rows.table, method).is_none();
            let missing: Vec<Method> = self.methods.iter().filter(is_missing).cloned().collect();
            let &Trial { mesh, ratio, seed } = trial;
            let event = Event::Case { mesh, ratio, seed, n_done: index * n_cases + at, n_cases: n_files * n_cases };
            if report(event).is_break() {
                return Ok(ControlFlow::Break(()));
            }
            if missing.is_empty() {
                continue;
            }
            let prepared = ready.get_or_insert_with(|| self.prepare(file));
            let Some(rows) = self.run_case(trial, prepared, &missing, report) else {
                return Ok(ControlFlow::Break(()));
            };
            self.rows.push(rows.clone())?;
            if rows.iter().any(|row| report(Event::Row(row)).is_break()) {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    fn engine(&self) -> Engine<'_> {
        let Request { worker, settings, weights, paper_weights, .. } = self.request;
        Engine {
            worker,
            time_limit: Duration::try_from_secs_f64(settings.time_limit).unwrap_or(Duration::MAX),
            threads: settings.threads,
            weights: [weights.as_deref(), paper_weights.as_deref()],
            learned: &self.learned,
            scratch: self.scratch,
        }
    }

    fn prepare(&self, file: &MeshFile) -> Result<PreparedMesh, String> {
        let mesh = read_mesh(&file.path)?;
        self.engine().prepare(&mesh, &self.methods)?;
        let Settings { samples, spectrum, .. } = self.request.settings;
        let mut judging = CompareOptions::default();
        judging.samples = samples;
        let along = if spectrum { IntrinsicOptions::default() } else { IntrinsicOptions::NONE };
        Ok(PreparedMesh { judge: Judge::new(&mesh, &judging, &along), mesh })
    }

    fn run_case(
        &self,
        trial: &Trial,
        prepared: &Result<PreparedMesh, String>,
        methods: &[Method],
        report: &mut dyn FnMut(Event) -> ControlFlow<()>,
    ) -> Option<Vec<ResultRow>> {
        let &Trial { mesh, ratio, seed } = trial;
        let blank = |method: &Method| ResultRow {
            seed,
            machine: self.machine.clone(),
            values: vec![None; self.n_figures],
            ..ResultRow::new(mesh, ratio, method.name(), &[])
        };
        let prepared = match prepared {
            Ok(prepared) => prepared,
            Err(why) => {
                let row = |method| ResultRow { error: format!("the input mesh: {why}"), ..blank(method) };
                return Some(methods.iter().map(row).collect());
            }
        };
        // An earlier run may have the leader's result already.
        let leader = self.methods.iter().find(|method| method.is_ours());
        let table = &self.rows.table;
        let known = leader.and_then(|leader| table.value(trial.row(table, leader)?, "faces_out"));
        let n_faces = known.map(|n| n as usize);
        let case = ContestCase { mesh: &prepared.mesh, ratio, seed, leader, n_faces };
        let repeats = self.request.settings.repeats;
        let mut wait = |method: &Method, round| report(Event::Running { method, round });
        let outcomes = run_case(&self.engine(), &case, methods, repeats, &mut wait)?;
        if report(Event::Judging).is_break() {
            return None;
        }
        let judged = methods.par_iter().zip(outcomes);
        Some(judged.map(|(method, outcome)| self.judge_outcome(blank(method), prepared, outcome)).collect())
    }

    fn judge_outcome(&self, blank: ResultRow, prepared: &PreparedMesh, outcome: MethodOutcome) -> ResultRow {
        let MethodOutcome { size, seconds, timed, result } = outcome;
        let PreparedMesh { mesh, judge } = prepared;
        let mut row = blank;
        let sizes = [mesh.positions().len(), mesh.faces().len(), size.vertices, size.faces];
        row.values.iter_mut().zip(sizes).for_each(|(value, size)| *value = Some(size as f64));
        match result {
            Err(error) => ResultRow { error, ..row },
            Ok(result) => {
                let seen_beside = self.request.settings.appearance.then_some(mesh);
                let figures = all_figures(judge, &result, size.vertices, seen_beside);
                let sizes = [result.positions().len(), result.faces().len()].map(|n| Some(n as f64));
                let runs = Some(seconds.len() as f64);
                let whole = Some(f64::from(u8::from(timed == Some(TimedScope::Process))));
                let timed = [median(seconds), runs, whole];
                let judged = figures.into_iter().map(|figure| figure.value);
                let values = sizes.into_iter().chain(timed).chain(judged);
                row.values[4..].iter_mut().zip(values).for_each(|(value, found)| *value = found);
                row
            }
        }
    }
}
