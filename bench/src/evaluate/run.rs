//! An evaluation from beginning to end.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rayon::prelude::*;

use super::contest::{ContestCase, MethodOutcome, run_case};
use super::engine::{Engine, Worker};
use super::folder::{inspect_folder, open_folder, scratch_in};
use super::meshes::{MeshFile, checksums, mesh_files, read_mesh};
use super::rehearsal::try_each;
use super::row::Conditions;
use super::rows_file::RowsFile;
use super::settings::{LearnedFile, Origin, learned_files, learned_names, weights_name};
use super::worst::WorstCaseStore;
use super::{EvaluateError, Method, ResultRow, Settings, Table, Tool, hardware};
use crate::along_surface::{IntrinsicOptions, Judge};
use neural_mesh::appearance::{self, Appearance, USUAL_HEIGHT, appearance};
use neural_mesh::mesh::{TriMesh, shapes};
use neural_mesh::metrics::{CompareOptions, Figure};
use neural_mesh::model::Weights;

/// Input of an evaluation.
#[derive(Clone, Debug)]
#[non_exhaustive]
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
    /// Worker process; without it our methods have no time limit, and a crash ends the evaluation.
    pub worker: Option<Worker>,
}

impl Request {
    /// Makes a request with default settings.
    pub fn new(data: impl Into<PathBuf>, folder: impl Into<PathBuf>) -> Self {
        Self {
            data: data.into(),
            folder: folder.into(),
            settings: Settings::default(),
            weights: None,
            paper_weights: None,
            learned_weights: Vec::new(),
            resume: false,
            worker: None,
        }
    }
}

/// An event during an evaluation.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Event<'a> {
    /// A tool is tried on a small mesh.
    Trying(&'a Tool),
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
    /// The caller stopped it while tools were tried; the folder is unchanged.
    NotBegun,
}

/// Measures every method at every ratio on every mesh and appends the rows to `rows.csv` case by case.
///
/// A killed run loses only the present case. `report` can stop the run by `Break`.
///
/// # Errors
/// [`EvaluateError`] about settings, data, folder or a tool.
///
/// ```
/// use neural_mesh_bench::evaluate::{Request, evaluate};
/// use std::ops::ControlFlow;
/// let folder = tempfile::tempdir().unwrap();
/// let request = Request::new(folder.path(), folder.path().join("run"));
/// let error = evaluate(&request, &mut |_| ControlFlow::Continue(())).unwrap_err();
/// assert!(error.to_string().contains("holds no mesh"));
/// ```
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
    let figures: Vec<String> = empty_figures().iter().map(|figure| figure.name.to_string()).collect();
    let found = inspect_folder(&request.folder, &origin, request.resume)?;
    if try_tools(request, &unfinished_tools(request, &methods, &files, &found.table), report)?.is_break() {
        return Ok(Ending::NotBegun);
    }
    let rows = open_folder(&request.folder, &origin, &found, &figures)?;
    let store = WorstCaseStore::new(&request.folder, &rows.table);
    let scratch = scratch_in(&request.folder)?;
    let (n_figures, scratch) = (figures.len(), scratch.path());
    let mut run = EvaluationRun { request, methods, origin, learned, rows, store, n_figures, scratch };
    for (index, file) in files.iter().enumerate() {
        if run.run_mesh(file, index, files.len(), report)?.is_break() {
            return Ok(Ending::Stopped);
        }
    }
    // A run killed after the last row may have left meshes to remove.
    run.store.remove_others();
    Ok(Ending::Finished)
}

fn unfinished_tools<'a>(request: &Request, methods: &'a [Method], files: &[MeshFile], table: &Table) -> Vec<&'a Tool> {
    let Settings { ratios, seeds, .. } = &request.settings;
    let n_cases = files.len() * ratios.len() * seeds.len();
    let n_rows = |tool: &Tool| table.rows.iter().filter(|row| row.method == tool.name).count();
    let tools = methods.iter().filter_map(|method| if let Method::Tool(tool) = method { Some(tool) } else { None });
    tools.filter(|tool| n_rows(tool) < n_cases).collect()
}

fn try_tools(
    request: &Request,
    tools: &[&Tool],
    report: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<ControlFlow<()>, EvaluateError> {
    let problem = |error| {
        EvaluateError::Tool(format!(
            "tools cannot be tried, as no temporary folder can be created: {error}: check TMPDIR"
        ))
    };
    // Tools are tried in a temporary folder, because that of the evaluation must stay unchanged until all of them work.
    let place = tempfile::tempdir().map_err(problem)?;
    try_each(&make_engine(request, &[], place.path()), tools, &mut |tool| report(Event::Trying(tool)))
}

fn make_engine<'a>(request: &'a Request, learned: &'a [LearnedFile], scratch: &'a Path) -> Engine<'a> {
    let Request { worker, settings, weights, paper_weights, .. } = request;
    Engine {
        worker: worker.as_ref(),
        time_limit: Duration::try_from_secs_f64(settings.time_limit).unwrap_or(Duration::MAX),
        threads: settings.threads,
        weights: [weights.as_deref(), paper_weights.as_deref()],
        learned,
        scratch,
    }
}

pub(super) fn empty_figures() -> Vec<Figure> {
    let mesh = shapes::icosphere(0);
    let mut judging = CompareOptions::default();
    judging.samples = 1;
    all_figures(&Judge::new(&mesh, &judging, &IntrinsicOptions::NONE), &mesh, 0, None)
}

fn all_figures(judge: &Judge, result: &TriMesh, n_asked: usize, looks: Option<&Appearance>) -> Vec<Figure> {
    let mut figures = judge.figures(result, n_asked);
    // The size has its own columns.
    figures.retain(|figure| !["vertices", "faces"].contains(&figure.name));
    figures.extend(appearance::figures(looks));
    figures
}

struct PreparedMesh {
    mesh: TriMesh,
    judge: Judge,
}

struct EvaluationRun<'a> {
    request: &'a Request,
    methods: Vec<Method>,
    origin: Origin,
    learned: Vec<LearnedFile>,
    rows: RowsFile,
    store: WorstCaseStore,
    n_figures: usize,
    scratch: &'a Path,
}

struct JudgedResult {
    row: ResultRow,
    result: Option<TriMesh>,
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
        let (n_cases, n_files) = (cases.len(), n_files * cases.len());
        let mut ready = None;
        for (at, trial) in cases.iter().enumerate() {
            let missing = self.missing_methods(trial);
            let &Trial { mesh, ratio, seed } = trial;
            let event = Event::Case { mesh, ratio, seed, n_done: index * n_cases + at, n_cases: n_files };
            if report(event).is_break() {
                return Ok(ControlFlow::Break(()));
            }
            if missing.is_empty() {
                continue;
            }
            let prepared = ready.get_or_insert_with(|| self.prepare(file));
            let Some(judged) = self.run_case(trial, prepared, &missing, report) else {
                return Ok(ControlFlow::Break(()));
            };
            // Meshes are saved before the rows, so that a run killed in between repeats the case.
            if let Ok(PreparedMesh { mesh, .. }) = prepared {
                self.save_worst(trial, mesh, &judged)?;
            }
            let rows: Vec<ResultRow> = judged.into_iter().map(|judged| judged.row).collect();
            self.rows.push(rows.clone())?;
            self.store.remove_others();
            if rows.iter().any(|row| report(Event::Row(row)).is_break()) {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    fn missing_methods(&self, trial: &Trial) -> Vec<Method> {
        let is_there = |method: &&Method| trial.row(&self.rows.table, method).is_none();
        self.methods.iter().filter(is_there).cloned().collect()
    }

    fn prepare(&self, file: &MeshFile) -> Result<PreparedMesh, String> {
        let mesh = read_mesh(&file.path)?;
        make_engine(self.request, &self.learned, self.scratch).prepare(&mesh, &self.methods)?;
        let (judging, along) = self.judging();
        Ok(PreparedMesh { judge: Judge::new(&mesh, &judging, &along), mesh })
    }

    fn judging(&self) -> (CompareOptions, IntrinsicOptions) {
        let Settings { samples, spectrum, .. } = self.request.settings;
        let mut judging = CompareOptions::default();
        judging.samples = samples;
        (judging, if spectrum { IntrinsicOptions::default() } else { IntrinsicOptions::NONE })
    }

    fn save_worst(&mut self, trial: &Trial, original: &TriMesh, judged: &[JudgedResult]) -> Result<(), EvaluateError> {
        let known = self.methods.iter().filter_map(|method| trial.row(&self.rows.table, method));
        let rows: Vec<&ResultRow> = known.chain(judged.iter().map(|judged| &judged.row)).collect();
        let results =
            judged.iter().filter_map(|JudgedResult { row, result }| Some((row.method.as_str(), result.as_ref()?)));
        let results: Vec<(&str, &TriMesh)> = results.collect();
        self.store.save(&self.rows.table, &rows, original, &results)
    }

    fn run_case(
        &self,
        trial: &Trial,
        prepared: &Result<PreparedMesh, String>,
        methods: &[Method],
        report: &mut dyn FnMut(Event) -> ControlFlow<()>,
    ) -> Option<Vec<JudgedResult>> {
        let &Trial { mesh, ratio, seed } = trial;
        let blank = |method: &Method| ResultRow {
            mesh: mesh.into(),
            ratio,
            seed,
            method: method.name().into(),
            conditions: self.conditions(method),
            figures: vec![None; self.n_figures],
            ..ResultRow::default()
        };
        let prepared = match prepared {
            Ok(prepared) => prepared,
            Err(why) => {
                let row = |method| ResultRow { error: format!("the input mesh: {why}"), ..blank(method) };
                let row = |method| JudgedResult { row: row(method), result: None };
                return Some(methods.iter().map(row).collect());
            }
        };
        // An earlier run may have the leader's result already.
        let leader = self.methods.iter().find(|method| method.is_ours());
        let known = leader.and_then(|leader| trial.row(&self.rows.table, leader)).filter(|row| row.error.is_empty());
        let n_faces = known.map(|row| row.faces_out);
        let case = ContestCase { mesh: &prepared.mesh, ratio, seed, leader, n_faces };
        let repeats = self.request.settings.repeats;
        let mut wait = |method: &Method, round| report(Event::Running { method, round });
        let outcomes =
            run_case(&make_engine(self.request, &self.learned, self.scratch), &case, methods, repeats, &mut wait)?;
        if report(Event::Judging).is_break() {
            return None;
        }
        let judged = methods.par_iter().zip(outcomes);
        Some(judged.map(|(method, outcome)| self.judge_outcome(blank(method), prepared, outcome)).collect())
    }

    fn judge_outcome(&self, blank: ResultRow, prepared: &PreparedMesh, outcome: MethodOutcome) -> JudgedResult {
        let MethodOutcome { size, seconds, timed, result } = outcome;
        let PreparedMesh { mesh, judge } = prepared;
        let row = ResultRow {
            vertices_in: mesh.positions().len(),
            faces_in: mesh.faces().len(),
            vertices_asked: size.vertices,
            faces_asked: size.faces,
            ..blank
        };
        match result {
            Err(error) => JudgedResult { row: ResultRow { error, ..row }, result: None },
            Ok(result) => {
                let figures =
                    all_figures(judge, &result, size.vertices, self.compare_appearance(mesh, &result).as_ref());
                let timed = timed.map_or(row.conditions.timed, |timed| timed.name().into());
                let row = ResultRow {
                    vertices_out: result.positions().len(),
                    faces_out: result.faces().len(),
                    seconds: median(seconds.clone()),
                    conditions: Conditions { runs: seconds.len(), timed, ..row.conditions },
                    figures: figures.into_iter().map(|figure| figure.value).collect(),
                    ..row
                };
                JudgedResult { row, result: Some(result) }
            }
        }
    }

    fn compare_appearance(&self, original: &TriMesh, result: &TriMesh) -> Option<Appearance> {
        let asked = self.request.settings.appearance;
        asked.then(|| appearance(original, result, USUAL_HEIGHT)).flatten()
    }

    fn conditions(&self, method: &Method) -> Conditions {
        let Settings { threads, time_limit, samples, .. } = self.request.settings;
        let [closed, paper] = &self.origin.weights;
        let weights = match method {
            Method::Network => closed.as_str(),
            _ if method.is_paper() => paper,
            Method::Learned(baseline) => self.origin.learned.get(baseline.name()).map_or("", String::as_str),
            _ => "",
        };
        Conditions {
            timed: if matches!(method, Method::Tool(_)) { "process" } else { "method" }.into(),
            runs: 0,
            threads,
            time_limit,
            samples,
            eigenpairs: self.judging().1.eigenpairs,
            weights: weights.chars().take(12).collect(),
            version: self.origin.version.clone(),
            cpu: hardware::cpu_model(),
            cores: hardware::core_count(),
        }
    }
}

/// Returns the median, for an even number the mean of the middle two; `None` for no values.
///
/// ```
/// assert_eq!(neural_mesh_bench::evaluate::median(vec![3.0, 1.0, 2.0, 9.0]), Some(2.5));
/// ```
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let last = values.get(n / 2)?;
    Some(if n % 2 == 1 { *last } else { 0.5 * (values[n / 2 - 1] + last) })
}
