//! An evaluation from beginning to end.

use std::path::Path;

use super::engine::{Case, Engine, MethodOutcome};
use super::folder::{open_folder, scratch_in};
use super::meshes::{checksums, file_name, mesh_files, read_mesh};
use super::method::Method;
use super::settings::{EvaluateOptions, Origin, Settings, weights_checksums};
use crate::along_surface::{EIGENPAIRS, Judge};
use crate::rows::{ResultRow, median};
use crate::rows_file::RowsFile;
use neural_mesh::appearance::{self, USUAL_HEIGHT, appearance};
use neural_mesh::mesh::{TriMesh, shapes};
use neural_mesh::metrics::{CompareOptions, Figure};
use neural_mesh::parallel;
use neural_mesh_cli::shared::Failure;
use neural_mesh_cli::shared::stopping::is_stop_requested;

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

/// Measures every method at every ratio on every mesh and appends the rows to `rows.csv` case by case.
///
/// A killed run loses only the present case. `say` gets a line for each case and failure. Returns whether all rows are
/// there; they are not after Ctrl-C.
///
/// # Errors
/// [`Failure`] about settings, data or folder.
pub fn evaluate(data: &Path, folder: &Path, options: &EvaluateOptions, say: &dyn Fn(&str)) -> Result<bool, Failure> {
    let methods = options.settings.resolve_methods()?;
    let files = mesh_files(data, &options.settings.only)?;
    let program = std::env::current_exe().map_err(|error| {
        Failure::Failed(format!("the path of this program cannot be found: {error}: start it by its full path"))
    })?;
    let origin = Origin {
        version: env!("CARGO_PKG_VERSION").into(),
        settings: options.settings.clone(),
        weights: weights_checksums(options)?,
        meshes: checksums(&files),
    };
    let judged = empty_figures().into_iter().map(|figure| figure.name);
    let figures: Vec<String> = SIZES.into_iter().chain(judged).map(String::from).collect();
    let rows = open_folder(folder, &origin, options.resume, &figures)?;
    let scratch = scratch_in(folder)?;
    let engine = Engine { program: &program, options, scratch: scratch.path() };
    let mut run = EvaluationRun { engine, methods, rows, n_figures: figures.len(), machine: machine(), say };
    for (index, file) in files.iter().enumerate() {
        if !run.run_mesh(file, index, files.len())? {
            return Ok(false);
        }
    }
    Ok(true)
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
    all_figures(&Judge::new(&mesh, &judging, None), &mesh, 0, None)
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
    engine: Engine<'a>,
    methods: Vec<Method>,
    rows: RowsFile,
    n_figures: usize,
    machine: String,
    say: &'a dyn Fn(&str),
}

impl EvaluationRun<'_> {
    fn known_row(&self, mesh: &str, ratio: f64, seed: u64, method: &Method) -> Option<&ResultRow> {
        self.rows.table.rows.iter().find(|row| row.is_case(mesh, ratio, seed, method.name()))
    }

    /// Measures the missing rows of a mesh; returns false if the evaluation is to stop.
    fn run_mesh(&mut self, file: &Path, index: usize, n_files: usize) -> Result<bool, Failure> {
        let Settings { ratios, seeds, .. } = &self.engine.options.settings;
        let name = file_name(file);
        let cases: Vec<(f64, u64)> =
            ratios.iter().flat_map(|&ratio| seeds.iter().map(move |&seed| (ratio, seed))).collect();
        let mut ready = None;
        for (at, &(ratio, seed)) in cases.iter().enumerate() {
            if is_stop_requested() {
                return Ok(false);
            }
            let is_missing = |method: &&Method| self.known_row(&name, ratio, seed, method).is_none();
            let missing: Vec<Method> = self.methods.iter().filter(is_missing).cloned().collect();
            if missing.is_empty() {
                continue;
            }
            let (n_done, n_cases) = (index * cases.len() + at, n_files * cases.len());
            (self.say)(&format!("measuring {name} at {ratio}, seed {seed} ({n_done} of {n_cases} cases done)"));
            let prepared = ready.get_or_insert_with(|| self.prepare(file));
            let blank = |method: &Method| ResultRow {
                seed,
                machine: self.machine.clone(),
                values: vec![None; self.n_figures],
                ..ResultRow::new(&name, ratio, method.name(), &[])
            };
            let blanks: Vec<ResultRow> = missing.iter().map(blank).collect();
            let rows = match prepared {
                Ok(prepared) => self.run_case(prepared, &missing, blanks),
                Err(why) => {
                    let fail = |row| ResultRow { error: format!("the input mesh: {why}"), ..row };
                    Some(blanks.into_iter().map(fail).collect())
                }
            };
            let Some(rows) = rows else { return Ok(false) };
            for ResultRow { mesh, ratio, method, error, .. } in rows.iter().filter(|row| !row.error.is_empty()) {
                (self.say)(&format!("failed    {mesh} at {ratio}, {method}: {error}"));
            }
            self.rows.push(rows)?;
        }
        Ok(true)
    }

    fn prepare(&self, file: &Path) -> Result<PreparedMesh, String> {
        let mesh = read_mesh(file)?;
        self.engine.prepare(&mesh)?;
        let Settings { samples, spectrum, .. } = self.engine.options.settings;
        let mut judging = CompareOptions::default();
        judging.samples = samples;
        Ok(PreparedMesh { judge: Judge::new(&mesh, &judging, spectrum.then_some(EIGENPAIRS)), mesh })
    }

    /// Fills the blank row of each method; `None` if the evaluation is to stop.
    fn run_case(&self, prepared: &PreparedMesh, methods: &[Method], blanks: Vec<ResultRow>) -> Option<Vec<ResultRow>> {
        let ResultRow { mesh, ratio, seed, .. } = blanks.first()?;
        // An earlier run may have the leader's result already.
        let leader = self.methods.iter().find(|method| method.is_ours());
        let known =
            leader.and_then(|leader| self.rows.table.value(self.known_row(mesh, *ratio, *seed, leader)?, "faces_out"));
        let n_faces = known.map(|n| n as usize);
        let case = Case { mesh: &prepared.mesh, ratio: *ratio, seed: *seed, leader, n_faces };
        let outcomes = self.engine.run_case(&case, methods)?;
        let has_pictures = self.engine.options.settings.appearance;
        let judge = |(row, outcome): (&ResultRow, _)| judge_outcome(row.clone(), prepared, outcome, has_pictures);
        Some(parallel::each(blanks.iter().zip(outcomes), judge))
    }
}

fn judge_outcome(mut row: ResultRow, prepared: &PreparedMesh, outcome: MethodOutcome, has_pictures: bool) -> ResultRow {
    let MethodOutcome { size, seconds, is_whole_process, result } = outcome;
    let PreparedMesh { mesh, judge } = prepared;
    let sizes = [mesh.positions().len(), mesh.faces().len(), size.vertices, size.faces];
    row.values.iter_mut().zip(sizes).for_each(|(value, size)| *value = Some(size as f64));
    let result = match result {
        Ok(result) => result,
        Err(error) => return ResultRow { error, ..row },
    };
    let figures = all_figures(judge, &result, size.vertices, has_pictures.then_some(mesh));
    let sizes = [result.positions().len(), result.faces().len()].map(|n| Some(n as f64));
    let runs = Some(seconds.len() as f64);
    let timed = [median(seconds), runs, Some(f64::from(u8::from(is_whole_process)))];
    let values = sizes.into_iter().chain(timed).chain(figures.into_iter().map(|figure| figure.value));
    row.values[4..].iter_mut().zip(values).for_each(|(value, found)| *value = found);
    row
}
