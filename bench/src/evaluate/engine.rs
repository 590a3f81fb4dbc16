//! Has a method simplify a mesh, each in the way that it can be stopped, and says how long it took.

use std::ffi::OsString;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::foreign::{self, Foreign};
use super::job::{self, Job, Work};
use super::limited::{Unfinished, run_limited, with_last_words, words_in};
use super::settings::LearnedFile;
use super::tool::Placeholders;
use super::{Method, Tool};
use crate::baselines::Size;
use neural_mesh::mesh::TriMesh;

/// A program that reads one line from standard input, gives it to [`answer`](super::answer), and prints the answer. It
/// should end when its standard input does, and with it all that it has started: then nobody waits for it any more.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Worker {
    /// The program.
    pub program: PathBuf,
    /// Its arguments.
    pub arguments: Vec<OsString>,
}

/// How methods are run.
pub(super) struct Engine<'a> {
    /// Runs the methods that are no tools; without one they run in this process, and nothing stops them.
    pub worker: Option<&'a Worker>,
    pub time_limit: Duration,
    pub threads: usize,
    /// Weights for the closed assembly and for the paper's.
    pub weights: [Option<&'a Path>; 2],
    /// Weights of learned baselines that are not those that ship.
    pub learned: &'a [LearnedFile],
    /// A folder that is nobody else's, which holds the mesh at hand.
    pub scratch: &'a Path,
}

/// What a method is asked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    pub ratio: f64,
    pub size: Size,
    pub seed: u64,
}

/// What a method did.
pub(super) struct Done {
    pub mesh: TriMesh,
    pub seconds: f64,
    /// What the seconds cover.
    pub timed: Timed,
}

/// What seconds cover.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Timed {
    /// The method, with the mesh in memory.
    Method,
    /// The whole process, with its start, reading and writing.
    Process,
}

impl Timed {
    /// The word in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Method => "method",
            Self::Process => "process",
        }
    }
}

impl Engine<'_> {
    /// Puts the mesh where the methods find it.
    pub fn prepare(&self, mesh: &TriMesh, methods: &[Method]) -> Result<(), String> {
        let tools = methods.iter().filter_map(|method| if let Method::Tool(tool) = method { Some(tool) } else { None });
        let mut endings: Vec<&str> = tools.filter_map(|tool| tool.ending("in")).chain(["ply"]).collect();
        endings.sort_unstable();
        endings.dedup();
        endings.into_iter().try_for_each(|ending| job::write_mesh(&self.input().with_extension(ending), mesh))
    }

    /// Has a method simplify the mesh at hand once.
    pub fn run(
        &self,
        method: &Method,
        asked: &Asked,
        wait: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<Done, Unfinished> {
        match method {
            Method::Tool(tool) => self.run_tool(tool, asked, wait),
            _ => self.run_own(method, asked, wait),
        }
    }

    fn run_own(
        &self,
        method: &Method,
        asked: &Asked,
        wait: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<Done, Unfinished> {
        let output = self.scratch.join("result.ply");
        let job = Job {
            input: self.input().with_extension("ply"),
            output: output.clone(),
            method: method.name().into(),
            vertices: asked.size.vertices,
            faces: asked.size.faces,
            seed: asked.seed,
            weights: self.weights_of(method).map(Path::to_path_buf),
            threads: self.threads,
        };
        let seconds = match self.worker {
            Some(worker) => self.ask(worker, &Work::Method(job), wait)?,
            None => job::run(&job).map_err(Unfinished::Failed)?,
        };
        let mesh = job::read_mesh(&output).and_then(with_faces).map_err(Unfinished::Failed)?;
        Ok(Done { mesh, seconds, timed: Timed::Method })
    }

    /// The file of the weights that a method uses; none for those that ship.
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

    /// Has a worker do the work.
    fn ask(&self, worker: &Worker, work: &Work, wait: &mut dyn FnMut() -> ControlFlow<()>) -> Result<f64, Unfinished> {
        let failed = |error: serde_json::Error| Unfinished::Failed(format!("the worker and its job: {error}"));
        let line = serde_json::to_string(work).map_err(failed)?;
        let mut command = Command::new(&worker.program);
        command.args(&worker.arguments);
        let finished = run_limited(command, &line, self.time_limit, self.scratch, wait)?;
        let answer: Result<f64, String> = serde_json::from_str(&finished.out).map_err(failed)?;
        let words = words_in(self.scratch);
        let out = if let Work::Foreign(foreign) = work { &foreign.out } else { &words };
        answer.map_err(|why| Unfinished::Failed(with_last_words(&why, &[&words, out])))
    }

    fn run_tool(
        &self,
        tool: &Tool,
        asked: &Asked,
        wait: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<Done, Unfinished> {
        // Files of its own: what it does to them does nothing to the others.
        let place = self.place_for(tool).map_err(|error| Unfinished::Failed(format!("a place for it: {error}")))?;
        let [input, output] = ["original", "result"].map(|name| place.path().join(name));
        let given = Placeholders { input: &input, output: &output, ratio: asked.ratio, size: asked.size };
        let out = place.path().join("stdout");
        let foreign = Foreign { words: tool.words(&given), threads: self.threads, out: out.clone() };
        let seconds = match self.worker {
            Some(worker) => self.ask(worker, &Work::Foreign(foreign), wait)?,
            None => {
                let command = foreign.command().map_err(Unfinished::Failed)?;
                let finished = run_limited(command, "", self.time_limit, self.scratch, wait)?;
                std::fs::write(&out, finished.out).map_err(|error| Unfinished::Failed(error.to_string()))?;
                finished.seconds
            }
        };
        let said = std::fs::read(&out).unwrap_or_default();
        let told = foreign::told_seconds(&String::from_utf8_lossy(&said)).map(|seconds| (seconds, Timed::Method));
        let (seconds, timed) = told.unwrap_or((seconds, Timed::Process));
        let output = output.with_extension(tool.ending("out").unwrap_or("ply"));
        let result = foreign::read(&output).and_then(with_faces);
        let mesh = result.map_err(|why| Unfinished::Failed(with_last_words(&why, &[&words_in(self.scratch), &out])))?;
        Ok(Done { mesh, seconds, timed })
    }

    /// A folder that goes when dropped, with a copy of the mesh at hand in the format that a tool reads.
    fn place_for(&self, tool: &Tool) -> std::io::Result<tempfile::TempDir> {
        let place = tempfile::tempdir_in(self.scratch)?;
        let input = self.input().with_extension(tool.ending("in").unwrap_or("ply"));
        std::fs::copy(&input, place.path().join("original").with_extension(input.extension().unwrap_or_default()))?;
        Ok(place)
    }

    /// The mesh at hand, without an ending.
    fn input(&self) -> PathBuf {
        self.scratch.join("original")
    }
}

fn with_faces(mesh: TriMesh) -> Result<TriMesh, String> {
    if mesh.faces().is_empty() { Err("the result has no face".into()) } else { Ok(mesh) }
}
