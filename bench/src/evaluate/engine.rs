//! Runs of methods, each in a process of its own, and cases whose methods run in turns.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::foreign::{self, ForeignRun};
use super::job::{self, Job, Work};
use super::limited::{RunFailure, append_last_output, join_lines, run_limited, stderr_path};
use super::method::Method;
use super::settings::EvaluateOptions;
use super::tool::{Placeholders, Tool};
use crate::baselines::TargetCounts;
use neural_mesh::mesh::TriMesh;
use neural_mesh_cli::shared::stopping::is_stop_requested;

pub(super) struct Engine<'a> {
    // This program, whose command `work` answers a job.
    pub program: &'a Path,
    pub options: &'a EvaluateOptions,
    pub scratch: &'a Path,
}

/// A mesh at a ratio, drawn by a seed.
pub(super) struct Case<'a> {
    pub mesh: &'a TriMesh,
    pub ratio: f64,
    pub seed: u64,
    // The first of our methods, whose resulting number of faces is the target of the others.
    pub leader: Option<&'a Method>,
    pub n_faces: Option<usize>,
}

/// Outcome of a method in a case.
pub(super) struct MethodOutcome {
    pub size: TargetCounts,
    // Seconds of each run.
    pub seconds: Vec<f64>,
    // True if the time is that of the whole process, with start, reading and writing.
    pub is_whole_process: bool,
    pub result: Result<TriMesh, String>,
}

struct RunResult {
    mesh: TriMesh,
    seconds: f64,
    is_whole_process: bool,
}

impl Case<'_> {
    fn size(&self, n_faces: Option<usize>) -> TargetCounts {
        let share = |n: usize| ((n as f64 * self.ratio) as usize).max(1);
        let faces = n_faces.unwrap_or_else(|| share(self.mesh.faces().len()));
        TargetCounts { vertices: share(self.mesh.positions().len()), faces }
    }
}

impl Engine<'_> {
    /// Writes the mesh that our methods and baselines read.
    pub fn prepare(&self, mesh: &TriMesh) -> Result<(), String> {
        job::write_mesh(&self.input(), mesh).map_err(|error| error.to_string())
    }

    /// Runs each method once per round; `None` if the evaluation is to stop.
    pub fn run_case(&self, case: &Case, methods: &[Method]) -> Option<Vec<MethodOutcome>> {
        let mut n_faces = case.n_faces;
        let mut outcomes: Vec<Option<MethodOutcome>> = methods.iter().map(|_| None).collect();
        let mut order: Vec<usize> = (0..methods.len()).collect();
        order.sort_by_key(|&at| case.leader != Some(&methods[at]));
        // Turns let a slow spell of the machine affect all methods.
        for &at in (0..self.options.settings.repeats).flat_map(|_| &order) {
            let (method, outcome) = (&methods[at], &mut outcomes[at]);
            // A method that failed is not run again and keeps its first error.
            if matches!(outcome, Some(MethodOutcome { result: Err(_), .. })) {
                continue;
            }
            let size = outcome.as_ref().map_or_else(|| case.size(n_faces), |outcome| outcome.size);
            let done = match self.run(method, case, size) {
                Err(RunFailure::Stopped) => return None,
                Err(RunFailure::Failed(why)) => Err(join_lines(&why)),
                Ok(done) => Ok(done),
            };
            if let Ok(RunResult { mesh, .. }) = &done
                && case.leader == Some(method)
            {
                n_faces = Some(mesh.faces().len());
            }
            match (outcome.as_mut(), done) {
                (Some(outcome), Ok(done)) => outcome.seconds.push(done.seconds),
                (_, done) => *outcome = Some(first_outcome(size, done)),
            }
        }
        outcomes.into_iter().collect()
    }

    fn run(&self, method: &Method, case: &Case, size: TargetCounts) -> Result<RunResult, RunFailure> {
        match method {
            Method::Tool(tool) => self.run_tool(tool, case, size),
            _ => self.run_own(method, case, size),
        }
    }

    fn run_own(&self, method: &Method, case: &Case, size: TargetCounts) -> Result<RunResult, RunFailure> {
        let output = self.scratch.join("result.ply");
        let job = Job {
            input: self.input(),
            output: output.clone(),
            method: method.name().into(),
            vertices: size.vertices,
            faces: size.faces,
            seed: case.seed,
            weights: if method.is_paper() { &self.options.paper_weights } else { &self.options.weights }.clone(),
            threads: self.options.settings.threads,
        };
        let seconds = self.run_worker(&Work::Method(job))?;
        let mesh = job::read_mesh(&output).map_err(|error| error.to_string()).and_then(check_has_faces);
        Ok(RunResult { mesh: mesh.map_err(RunFailure::Failed)?, seconds, is_whole_process: false })
    }

    fn run_worker(&self, work: &Work) -> Result<f64, RunFailure> {
        let failed =
            |error: serde_json::Error| RunFailure::Failed(format!("the worker process gave no valid answer: {error}"));
        let line = serde_json::to_string(work).map_err(failed)?;
        let mut command = Command::new(self.program);
        command.arg("work");
        let limit = Duration::try_from_secs_f64(self.options.settings.time_limit).unwrap_or(Duration::MAX);
        let out = run_limited(command, &line, limit, self.scratch, is_stop_requested)?;
        let answer: Result<f64, String> = serde_json::from_str(&out).map_err(failed)?;
        let words = stderr_path(self.scratch);
        let out = if let Work::Foreign(foreign) = work { &foreign.out } else { &words };
        answer.map_err(|why| RunFailure::Failed(append_last_output(&why, &[&words, out])))
    }

    fn run_tool(&self, tool: &Tool, case: &Case, size: TargetCounts) -> Result<RunResult, RunFailure> {
        // Each tool has a folder of its own, so that changes to its files do not affect other methods.
        let failed = |what: String| RunFailure::Failed(format!("its input cannot be written: {what}"));
        let folder = tempfile::tempdir_in(self.scratch).map_err(|error| failed(error.to_string()))?;
        let [input, output] = ["original", "result"].map(|name| folder.path().join(name));
        let written = job::write_mesh(&input.with_extension(tool.ending("in").unwrap_or("ply")), case.mesh);
        written.map_err(|error| failed(error.to_string()))?;
        let given = Placeholders { input: &input, output: &output, ratio: case.ratio, size };
        let out = folder.path().join("stdout");
        let threads = self.options.settings.threads;
        let foreign = ForeignRun { words: tool.words(&given), threads, out: out.clone() };
        let seconds = self.run_worker(&Work::Foreign(foreign))?;
        let printed = std::fs::read(&out).unwrap_or_default();
        let reported = foreign::reported_seconds(&String::from_utf8_lossy(&printed));
        let output = output.with_extension(tool.ending("out").unwrap_or("ply"));
        let result = foreign::read_result(&output).and_then(check_has_faces);
        let mesh =
            result.map_err(|why| RunFailure::Failed(append_last_output(&why, &[&stderr_path(self.scratch), &out])))?;
        Ok(RunResult { mesh, seconds: reported.unwrap_or(seconds), is_whole_process: reported.is_none() })
    }

    fn input(&self) -> PathBuf {
        self.scratch.join("original.ply")
    }
}

fn first_outcome(size: TargetCounts, done: Result<RunResult, String>) -> MethodOutcome {
    match done {
        Ok(RunResult { mesh, seconds, is_whole_process }) => {
            MethodOutcome { size, seconds: vec![seconds], is_whole_process, result: Ok(mesh) }
        }
        Err(why) => MethodOutcome { size, seconds: Vec::new(), is_whole_process: false, result: Err(why) },
    }
}

fn check_has_faces(mesh: TriMesh) -> Result<TriMesh, String> {
    if mesh.faces().is_empty() { Err("the result has no face".into()) } else { Ok(mesh) }
}
