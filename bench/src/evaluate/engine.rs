//! Runs of methods that can be stopped.

use std::ffi::OsString;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::foreign::{self, ForeignRun};
use super::job::{self, Job, Work};
use super::limited::{RunFailure, append_last_output, run_limited, stderr_path};
use super::method::Method;
use super::settings::LearnedFile;
use super::tool::{Placeholders, Tool};
use crate::baselines::TargetCounts;
use neural_mesh::mesh::TriMesh;

/// A program that passes one line of standard input to [`answer_job`](super::answer_job) and prints the answer.
///
/// It should end, with all its children, when its standard input ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Worker {
    /// Path of the program.
    pub program: PathBuf,
    /// Arguments.
    pub arguments: Vec<OsString>,
}

pub(super) struct Engine<'a> {
    pub worker: &'a Worker,
    pub time_limit: Duration,
    pub threads: usize,
    // Weights files of the closed and of the paper's assembly; shipped weights if `None`.
    pub weights: [Option<&'a Path>; 2],
    pub learned: &'a [LearnedFile],
    pub scratch: &'a Path,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct RunTarget {
    pub ratio: f64,
    pub size: TargetCounts,
    pub seed: u64,
}

pub(super) struct RunResult {
    pub mesh: TriMesh,
    pub seconds: f64,
    pub timed: TimedScope,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TimedScope {
    // The time is that of the method alone, with the mesh in memory.
    Method,
    // The time is that of the whole process, with start, reading and writing.
    Process,
}

impl Engine<'_> {
    pub fn prepare(&self, mesh: &TriMesh, methods: &[Method]) -> Result<(), String> {
        let tools = methods.iter().filter_map(|method| if let Method::Tool(tool) = method { Some(tool) } else { None });
        let mut endings: Vec<&str> = tools.filter_map(|tool| tool.ending("in")).chain(["ply"]).collect();
        endings.sort_unstable();
        endings.dedup();
        endings.into_iter().try_for_each(|ending| job::write_mesh(&self.input().with_extension(ending), mesh))
    }

    pub fn run(
        &self,
        method: &Method,
        target: &RunTarget,
        wait: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<RunResult, RunFailure> {
        match method {
            Method::Tool(tool) => self.run_tool(tool, target, wait),
            _ => self.run_own(method, target, wait),
        }
    }

    fn run_own(
        &self,
        method: &Method,
        target: &RunTarget,
        wait: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<RunResult, RunFailure> {
        let output = self.scratch.join("result.ply");
        let job = Job {
            input: self.input().with_extension("ply"),
            output: output.clone(),
            method: method.name().into(),
            vertices: target.size.vertices,
            faces: target.size.faces,
            seed: target.seed,
            weights: self.weights_of(method).map(Path::to_path_buf),
            threads: self.threads,
        };
        let seconds = self.run_worker(&Work::Method(job), wait)?;
        let mesh = job::read_mesh(&output).and_then(check_has_faces).map_err(RunFailure::Failed)?;
        Ok(RunResult { mesh, seconds, timed: TimedScope::Method })
    }

    fn weights_of(&self, method: &Method) -> Option<&Path> {
        let [closed, paper] = self.weights;
        match method {
            _ if method.is_paper() => paper,
            Method::Learned(baseline) => {
                self.learned.iter().find(|file| file.baseline == *baseline).map(|file| file.path.as_path())
            }
            _ => closed,
        }
    }

    fn run_worker(&self, work: &Work, wait: &mut dyn FnMut() -> ControlFlow<()>) -> Result<f64, RunFailure> {
        let failed =
            |error: serde_json::Error| RunFailure::Failed(format!("the worker process gave no valid answer: {error}"));
        let line = serde_json::to_string(work).map_err(failed)?;
        let mut command = Command::new(&self.worker.program);
        command.args(&self.worker.arguments);
        let out = run_limited(command, &line, self.time_limit, self.scratch, wait)?;
        let answer: Result<f64, String> = serde_json::from_str(&out).map_err(failed)?;
        let words = stderr_path(self.scratch);
        let out = if let Work::Foreign(foreign) = work { &foreign.out } else { &words };
        answer.map_err(|why| RunFailure::Failed(append_last_output(&why, &[&words, out])))
    }

    fn run_tool(
        &self,
        tool: &Tool,
        target: &RunTarget,
        wait: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<RunResult, RunFailure> {
        // Each tool has a folder of its own, so that changes to its files do not affect other methods.
        let folder = self.copy_input_for(tool).map_err(|error| {
            RunFailure::Failed(format!(
                "its input cannot be copied: {error}: check the folder of the results and the disk"
            ))
        })?;
        let [input, output] = ["original", "result"].map(|name| folder.path().join(name));
        let given = Placeholders { input: &input, output: &output, ratio: target.ratio, size: target.size };
        let out = folder.path().join("stdout");
        let foreign = ForeignRun { words: tool.words(&given), threads: self.threads, out: out.clone() };
        let seconds = self.run_worker(&Work::Foreign(foreign), wait)?;
        let printed = std::fs::read(&out).unwrap_or_default();
        let reported =
            foreign::reported_seconds(&String::from_utf8_lossy(&printed)).map(|seconds| (seconds, TimedScope::Method));
        let (seconds, timed) = reported.unwrap_or((seconds, TimedScope::Process));
        let output = output.with_extension(tool.ending("out").unwrap_or("ply"));
        let result = foreign::read_result(&output).and_then(check_has_faces);
        let mesh =
            result.map_err(|why| RunFailure::Failed(append_last_output(&why, &[&stderr_path(self.scratch), &out])))?;
        Ok(RunResult { mesh, seconds, timed })
    }

    fn copy_input_for(&self, tool: &Tool) -> std::io::Result<tempfile::TempDir> {
        let folder = tempfile::tempdir_in(self.scratch)?;
        let input = self.input().with_extension(tool.ending("in").unwrap_or("ply"));
        std::fs::copy(&input, folder.path().join("original").with_extension(input.extension().unwrap_or_default()))?;
        Ok(folder)
    }

    fn input(&self) -> PathBuf {
        self.scratch.join("original")
    }
}

fn check_has_faces(mesh: TriMesh) -> Result<TriMesh, String> {
    if mesh.faces().is_empty() { Err("the result has no face".into()) } else { Ok(mesh) }
}
