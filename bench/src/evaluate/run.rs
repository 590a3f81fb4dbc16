//! An evaluation from beginning to end: meshes, cases, methods, figures, rows.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rayon::prelude::*;

use super::contest::{Case, Outcome, contest};
use super::engine::{Engine, Worker};
use super::folder::{look_into, open_folder, scratch_in};
use super::meshes::{MeshFile, checksums, mesh_files, read_mesh};
use super::rehearsal::rehearse;
use super::row::How;
use super::rows_file::RowsFile;
use super::settings::{LearnedFile, Origin, learned_files, learned_names, weights_name};
use super::worst::Keeper;
use super::{EvaluateError, Method, Row, Settings, Table, Tool, hardware};
use crate::along_surface::{AlongJudging, Judge};
use neural_mesh::appearance::{self, Appearance, USUAL_HEIGHT, appearance};
use neural_mesh::mesh::{TriMesh, shapes};
use neural_mesh::metrics::{CompareOptions, Figure};
use neural_mesh::model::Weights;

/// What a caller asks for.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Request {
    /// Folder with the meshes.
    pub data: PathBuf,
    /// Folder for all that comes of it: made if missing.
    pub folder: PathBuf,
    /// What is measured and how.
    pub settings: Settings,
    /// File of the closed assembly's weights; without, those that ship.
    pub weights: Option<PathBuf>,
    /// File of the paper assembly's weights; without, those that ship.
    pub paper_weights: Option<PathBuf>,
    /// Files of weights of learned baselines, each of which says whose they are; without, those that ship.
    pub learned_weights: Vec<PathBuf>,
    /// Whether to go on with the rows that are there.
    pub resume: bool,
    /// Runs the methods that are no tools in a process of its own, which can be stopped. Without, they run in this one,
    /// the time limit holds for tools only, and a method that crashes ends the evaluation.
    pub worker: Option<Worker>,
}

impl Request {
    /// A new evaluation of the meshes in `data`, into `folder`, with the default settings and the weights that ship, in this process.
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

/// What happens during an evaluation.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Event<'a> {
    /// A tool is tried on a small mesh; heard again and again while it is.
    Trying(&'a Tool),
    /// A case begins: a mesh at a size with a seed.
    Case {
        /// Name of the mesh file.
        mesh: &'a str,
        /// Share of the vertices.
        ratio: f64,
        /// Seed of the sampling.
        seed: u64,
        /// Cases before this one, those of earlier runs too.
        n_done: usize,
        /// Cases in all.
        n_cases: usize,
    },
    /// A method is at work; heard again and again while it is.
    Running {
        /// The method.
        method: &'a Method,
        /// Its run, counted from 0.
        round: usize,
    },
    /// All methods are done, the results are measured.
    Judging,
    /// A row is in the table.
    Row(&'a Row),
}

/// How an evaluation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Every row is there.
    Finished,
    /// The caller asked to stop; the rows so far are kept.
    Stopped,
    /// The caller asked to stop while tools were tried; the folder is as it was.
    NotBegun,
}

/// Measures every method at every size on every mesh, and adds the rows to `rows.csv` in the folder, case by case.
/// `hear` can stop it at any time; stopped or killed, it loses the case at hand and no other. Before that each tool that
/// lacks rows is tried once on a small mesh. Of each method the meshes of its worst cases are kept ([`worst`](super::worst)).
///
/// # Errors
/// [`EvaluateError`] says what is wrong with settings, data, folder or a tool. A method that fails, and a mesh that cannot be
/// read, is a row with its error.
///
/// ```
/// use neural_mesh_bench::evaluate::{Request, evaluate};
/// use std::ops::ControlFlow;
/// let folder = tempfile::tempdir().unwrap();
/// let request = Request::new(folder.path(), folder.path().join("run"));
/// let error = evaluate(&request, &mut |_| ControlFlow::Continue(())).unwrap_err();
/// assert!(error.to_string().contains("holds no mesh"));
/// ```
pub fn evaluate(request: &Request, hear: &mut dyn FnMut(Event) -> ControlFlow<()>) -> Result<Ending, EvaluateError> {
    let methods = request.settings.checked()?;
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
    let figures: Vec<String> = figures().iter().map(|figure| figure.name.to_string()).collect();
    let found = look_into(&request.folder, &origin, request.resume)?;
    if try_tools(request, &with_work(request, &methods, &files, &found.table), hear)?.is_break() {
        return Ok(Ending::NotBegun);
    }
    let rows = open_folder(&request.folder, &origin, &found, &figures)?;
    let keeper = Keeper::new(&request.folder, &rows.table);
    let scratch = scratch_in(&request.folder)?;
    let (n_figures, scratch) = (figures.len(), scratch.path());
    let mut run = Run { request, methods, origin, learned, rows, keeper, n_figures, scratch };
    for (index, file) in files.iter().enumerate() {
        if run.mesh(file, index, files.len(), hear)?.is_break() {
            return Ok(Ending::Stopped);
        }
    }
    // Who was killed after the last row has left what is removed here.
    run.keeper.tidy();
    Ok(Ending::Finished)
}

/// The tools that lack rows.
fn with_work<'a>(request: &Request, methods: &'a [Method], files: &[MeshFile], table: &Table) -> Vec<&'a Tool> {
    let Settings { ratios, seeds, .. } = &request.settings;
    let n_cases = files.len() * ratios.len() * seeds.len();
    let n_rows = |tool: &Tool| table.rows.iter().filter(|row| row.method == tool.name).count();
    let tools = methods.iter().filter_map(|method| if let Method::Tool(tool) = method { Some(tool) } else { None });
    tools.filter(|tool| n_rows(tool) < n_cases).collect()
}

/// Tries tools in a folder of the system, as nothing may be in the folder of the evaluation yet.
fn try_tools(
    request: &Request,
    tools: &[&Tool],
    hear: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<ControlFlow<()>, EvaluateError> {
    let problem = |error| EvaluateError::Tool(format!("a place to try tools cannot be had: {error}: check TMPDIR"));
    let place = tempfile::tempdir().map_err(problem)?;
    rehearse(&engine(request, &[], place.path()), tools, &mut |tool| hear(Event::Trying(tool)))
}

/// How methods are run, in a folder of their own.
fn engine<'a>(request: &'a Request, learned: &'a [LearnedFile], scratch: &'a Path) -> Engine<'a> {
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

/// The figures that every row has, without values.
pub(super) fn figures() -> Vec<Figure> {
    let mesh = shapes::icosphere(0);
    let mut judging = CompareOptions::default();
    judging.samples = 1;
    compared(&Judge::new(&mesh, &judging, &AlongJudging::NONE), &mesh, 0, None)
}

/// The figures of a result but its size, which has columns of its own.
fn compared(judge: &Judge, result: &TriMesh, n_asked: usize, looks: Option<&Appearance>) -> Vec<Figure> {
    let mut figures = judge.figures(result, n_asked);
    figures.retain(|figure| !["vertices", "faces"].contains(&figure.name));
    figures.extend(appearance::figures(looks));
    figures
}

/// A mesh, and what its results are measured against.
struct Subject {
    mesh: TriMesh,
    judge: Judge,
}

struct Run<'a> {
    request: &'a Request,
    methods: Vec<Method>,
    origin: Origin,
    learned: Vec<LearnedFile>,
    rows: RowsFile,
    keeper: Keeper,
    n_figures: usize,
    scratch: &'a Path,
}

/// A row, and the mesh that it is of.
struct Judged {
    row: Row,
    result: Option<TriMesh>,
}

/// What all methods are asked for at once: a mesh by name, the share of its vertices to keep, a seed.
struct Trial<'a> {
    mesh: &'a str,
    ratio: f64,
    seed: u64,
}

impl Trial<'_> {
    /// The row of a method, where it is there.
    fn row<'a>(&self, table: &'a Table, method: &Method) -> Option<&'a Row> {
        table.rows.iter().find(|row| row.is_of(self.mesh, self.ratio, self.seed, method.name()))
    }
}

impl Run<'_> {
    /// Every case of a mesh that is not in the table yet.
    fn mesh(
        &mut self,
        file: &MeshFile,
        index: usize,
        n_files: usize,
        hear: &mut dyn FnMut(Event) -> ControlFlow<()>,
    ) -> Result<ControlFlow<()>, EvaluateError> {
        let Settings { ratios, seeds, .. } = &self.request.settings;
        let mesh = &file.name;
        let cases: Vec<Trial> =
            ratios.iter().flat_map(|&ratio| seeds.iter().map(move |&seed| Trial { mesh, ratio, seed })).collect();
        let (n_cases, n_files) = (cases.len(), n_files * cases.len());
        let mut ready = None;
        for (at, trial) in cases.iter().enumerate() {
            let missing = self.missing(trial);
            let &Trial { mesh, ratio, seed } = trial;
            let event = Event::Case { mesh, ratio, seed, n_done: index * n_cases + at, n_cases: n_files };
            if hear(event).is_break() {
                return Ok(ControlFlow::Break(()));
            }
            if missing.is_empty() {
                continue;
            }
            let subject = ready.get_or_insert_with(|| self.made_ready(file));
            let Some(judged) = self.case(trial, subject, &missing, hear) else {
                return Ok(ControlFlow::Break(()));
            };
            // Before the rows: who is killed between the two does the case again.
            if let Ok(Subject { mesh, .. }) = subject {
                self.keep(trial, mesh, &judged)?;
            }
            let rows: Vec<Row> = judged.into_iter().map(|judged| judged.row).collect();
            self.rows.push(rows.clone())?;
            self.keeper.tidy();
            if rows.iter().any(|row| hear(Event::Row(row)).is_break()) {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    /// The methods whose rows are not there yet.
    fn missing(&self, trial: &Trial) -> Vec<Method> {
        let is_there = |method: &&Method| trial.row(&self.rows.table, method).is_none();
        self.methods.iter().filter(is_there).cloned().collect()
    }

    fn made_ready(&self, file: &MeshFile) -> Result<Subject, String> {
        let mesh = read_mesh(&file.path)?;
        engine(self.request, &self.learned, self.scratch).prepare(&mesh, &self.methods)?;
        let (judging, along) = self.judging();
        Ok(Subject { judge: Judge::new(&mesh, &judging, &along), mesh })
    }

    fn judging(&self) -> (CompareOptions, AlongJudging) {
        let Settings { samples, spectrum, .. } = self.request.settings;
        let mut judging = CompareOptions::default();
        judging.samples = samples;
        (judging, if spectrum { AlongJudging::default() } else { AlongJudging::NONE })
    }

    /// Keeps the meshes of a case where they are among the worst of a method.
    fn keep(&mut self, trial: &Trial, original: &TriMesh, judged: &[Judged]) -> Result<(), EvaluateError> {
        let known = self.methods.iter().filter_map(|method| trial.row(&self.rows.table, method));
        let rows: Vec<&Row> = known.chain(judged.iter().map(|judged| &judged.row)).collect();
        let results = judged.iter().filter_map(|Judged { row, result }| Some((row.method.as_str(), result.as_ref()?)));
        let results: Vec<(&str, &TriMesh)> = results.collect();
        self.keeper.keep(&self.rows.table, &rows, original, &results)
    }

    /// The rows of a case; `None` where `hear` asked to stop.
    fn case(
        &self,
        trial: &Trial,
        subject: &Result<Subject, String>,
        methods: &[Method],
        hear: &mut dyn FnMut(Event) -> ControlFlow<()>,
    ) -> Option<Vec<Judged>> {
        let &Trial { mesh, ratio, seed } = trial;
        let blank = |method: &Method| Row {
            mesh: mesh.into(),
            ratio,
            seed,
            method: method.name().into(),
            how: self.how(method),
            figures: vec![None; self.n_figures],
            ..Row::default()
        };
        let subject = match subject {
            Ok(subject) => subject,
            Err(why) => {
                let row = |method| Row { error: format!("the mesh: {why}"), ..blank(method) };
                let row = |method| Judged { row: row(method), result: None };
                return Some(methods.iter().map(row).collect());
            }
        };
        let leader = self.methods.iter().find(|method| method.is_ours());
        let known = leader.and_then(|leader| trial.row(&self.rows.table, leader)).filter(|row| row.error.is_empty());
        let n_faces = known.map(|row| row.faces_out);
        let case = Case { mesh: &subject.mesh, ratio, seed, leader, n_faces };
        let repeats = self.request.settings.repeats;
        let mut wait = |method: &Method, round| hear(Event::Running { method, round });
        let outcomes = contest(&engine(self.request, &self.learned, self.scratch), &case, methods, repeats, &mut wait)?;
        if hear(Event::Judging).is_break() {
            return None;
        }
        let judged = methods.par_iter().zip(outcomes);
        Some(judged.map(|(method, outcome)| self.judged(blank(method), subject, outcome)).collect())
    }

    /// What came of a method, with its row.
    fn judged(&self, blank: Row, subject: &Subject, outcome: Outcome) -> Judged {
        let Outcome { size, seconds, timed, result } = outcome;
        let Subject { mesh, judge } = subject;
        let row = Row {
            vertices_in: mesh.positions().len(),
            faces_in: mesh.faces().len(),
            vertices_asked: size.vertices,
            faces_asked: size.faces,
            ..blank
        };
        match result {
            Err(error) => Judged { row: Row { error, ..row }, result: None },
            Ok(result) => {
                let figures = compared(judge, &result, size.vertices, self.looks(mesh, &result).as_ref());
                let timed = timed.map_or(row.how.timed, |timed| timed.name().into());
                let row = Row {
                    vertices_out: result.positions().len(),
                    faces_out: result.faces().len(),
                    seconds: median(seconds.clone()),
                    how: How { runs: seconds.len(), timed, ..row.how },
                    figures: figures.into_iter().map(|figure| figure.value).collect(),
                    ..row
                };
                Judged { row, result: Some(result) }
            }
        }
    }

    /// How alike original and result look, where that was asked for.
    fn looks(&self, original: &TriMesh, result: &TriMesh) -> Option<Appearance> {
        let asked = self.request.settings.appearance;
        asked.then(|| appearance(original, result, USUAL_HEIGHT)).flatten()
    }

    fn how(&self, method: &Method) -> How {
        let Settings { threads, time_limit, samples, .. } = self.request.settings;
        let [closed, paper] = &self.origin.weights;
        let weights = match method {
            Method::Network => closed.as_str(),
            _ if method.is_paper() => paper,
            Method::Learned(baseline) => self.origin.learned.get(baseline.name()).map_or("", String::as_str),
            _ => "",
        };
        How {
            timed: if matches!(method, Method::Tool(_)) { "process" } else { "method" }.into(),
            runs: 0,
            threads,
            time_limit,
            samples,
            eigenpairs: self.judging().1.eigenpairs,
            weights: weights.chars().take(12).collect(),
            version: self.origin.version.clone(),
            cpu: hardware::cpu(),
            cores: hardware::cores(),
        }
    }
}

/// The middle of the values, the mean of the middle two where there are two; `None` of none.
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
