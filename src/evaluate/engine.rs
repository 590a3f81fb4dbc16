//! Has a method simplify a mesh, each in the way that it can be stopped, and says how long it took.

use std::ffi::OsString;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::job::{self, Job};
use super::limited::{Unfinished, run_limited};
use super::tool::Places;
use super::{Method, Tool};
use crate::baselines::Size;
use crate::io::read_path;
use crate::mesh::TriMesh;
use crate::mesh::cleanup::{CleanOptions, clean};

/// A program that reads one line from standard input, gives it to [`answer`](super::answer), and prints the answer. It
/// should end when its standard input does: then nobody waits for it any more.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Worker {
    /// The program.
    pub program: PathBuf,
    /// Its arguments.
    pub arguments: Vec<OsString>,
}

/// How methods are run.
pub(super) struct Engine<'a> {
    /// Runs the methods of the library; without one they run in this process, and nothing stops them.
    pub worker: Option<&'a Worker>,
    pub time_limit: Duration,
    pub threads: usize,
    /// Weights for the closed assembly and for the paper's.
    pub weights: [Option<&'a Path>; 2],
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
        let [closed, paper] = self.weights;
        let job = Job {
            input: self.input().with_extension("ply"),
            output: output.clone(),
            method: method.name().into(),
            vertices: asked.size.vertices,
            faces: asked.size.faces,
            seed: asked.seed,
            weights: if *method == Method::Paper { paper } else { closed }.map(Path::to_path_buf),
            threads: self.threads,
        };
        let seconds = match self.worker {
            Some(worker) => self.ask(worker, &job, wait)?,
            None => job::run(&job).map_err(Unfinished::Failed)?,
        };
        let mesh = job::read_mesh(&output).map_err(Unfinished::Failed)?;
        with_faces(mesh, seconds)
    }

    /// Has a worker do the job.
    fn ask(&self, worker: &Worker, job: &Job, wait: &mut dyn FnMut() -> ControlFlow<()>) -> Result<f64, Unfinished> {
        let failed = |error: serde_json::Error| Unfinished::Failed(format!("the worker and its job: {error}"));
        let line = serde_json::to_string(job).map_err(failed)?;
        let mut command = Command::new(&worker.program);
        command.args(&worker.arguments);
        let finished = run_limited(command, &line, self.time_limit, self.scratch, wait)?;
        let answer: Result<f64, String> = serde_json::from_str(&finished.out).map_err(failed)?;
        answer.map_err(Unfinished::Failed)
    }

    fn run_tool(
        &self,
        tool: &Tool,
        asked: &Asked,
        wait: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<Done, Unfinished> {
        let output = self.scratch.join("result");
        let places = Places { input: &self.input(), output: &output, ratio: asked.ratio, size: asked.size };
        let output = output.with_extension(tool.ending("out").unwrap_or("ply"));
        // What an earlier run left is not this one's result.
        let _ = std::fs::remove_file(&output);
        let words = tool.words(&places);
        let Some((program, arguments)) = words.split_first() else {
            return Err(Unfinished::Failed("the command is empty".into()));
        };
        let mut command = Command::new(program);
        command.args(arguments);
        let seconds = run_limited(command, "", self.time_limit, self.scratch, wait)?.seconds;
        with_faces(read_foreign(&output).map_err(Unfinished::Failed)?, seconds)
    }

    /// The mesh at hand, without an ending.
    fn input(&self) -> PathBuf {
        self.scratch.join("original")
    }
}

fn with_faces(mesh: TriMesh, seconds: f64) -> Result<Done, Unfinished> {
    if mesh.faces().is_empty() {
        return Err(Unfinished::Failed("the result has no face".into()));
    }
    Ok(Done { mesh, seconds })
}

/// Reads what a program of others has written: welded and cleaned, in the coordinates of the file.
fn read_foreign(path: &Path) -> Result<TriMesh, String> {
    if !path.exists() {
        return Err("left no result".into());
    }
    let raw = read_path(path, None).map_err(|error| format!("the result: {error}"))?;
    let cleaned = clean(raw, &CleanOptions::default()).map_err(|error| format!("the result: {error}"))?;
    let positions = cleaned.mesh.positions().iter().map(|&local| cleaned.frame.to_file(local).map(|x| x as f32));
    TriMesh::new(positions.collect(), cleaned.mesh.faces().to_vec()).map_err(|error| format!("the result: {error}"))
}
