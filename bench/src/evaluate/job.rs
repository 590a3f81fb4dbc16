//! One run of a method that is no tool: what is asked, and the answer. A job, like the run of a program of others, can go
//! to another process as a line of JSON, so that a method that hangs or crashes takes nothing else with it, and so that
//! nothing runs on when the evaluation is killed.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::Method;
use super::clock::Moment;
use super::foreign::{self, Foreign};
use crate::baselines::{Size, simplify_by};
use crate::learned_baselines::{LearnedBaseline, LearnedWeights, simplify_by_learned};
use neural_mesh::io::{Format, read_path, write, write_path};
use neural_mesh::mesh::{Frame, TriMesh};
use neural_mesh::model::Weights;
use neural_mesh::simplify::{Assembly, Effort, Optimize, Options, ScoreSource, Target, simplify};

/// What one run is to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Job {
    /// Mesh file to simplify, written by [`write_mesh`].
    pub input: PathBuf,
    /// File for the result.
    pub output: PathBuf,
    /// Name of the method, not of a tool.
    pub method: String,
    pub vertices: usize,
    pub faces: usize,
    pub seed: u64,
    /// File of the network's weights; without, those that ship.
    pub weights: Option<PathBuf>,
    pub threads: usize,
}

/// What a worker does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Work {
    /// Runs a method that is no tool.
    Method(Job),
    /// Runs a program of others.
    Foreign(Foreign),
}

/// Does the work that came as a line of JSON, and answers in one: what the process does that a
/// [`Worker`](super::Worker) starts.
///
/// ```
/// let answer = neural_mesh_bench::evaluate::answer("no work");
/// assert!(answer.starts_with("{\"Err\":"));
/// ```
pub fn answer(line: &str) -> String {
    let done = match serde_json::from_str(line) {
        Ok(Work::Method(job)) => run(&job),
        Ok(Work::Foreign(foreign)) => foreign::run(&foreign),
        Err(error) => Err(format!("no work: {error}")),
    };
    serde_json::to_string(&done).unwrap_or_default()
}

/// Does a job: seconds of the method alone, with the mesh in memory, the weights read and the threads started; on one
/// thread those of the processor.
pub(super) fn run(job: &Job) -> Result<f64, String> {
    let mesh = read_mesh(&job.input)?;
    let method = Method::from_name(&job.method).ok_or_else(|| format!("unknown method {}", job.method))?;
    let weights = weights(&method, job.weights.as_deref())?;
    let threads =
        rayon::ThreadPoolBuilder::new().num_threads(job.threads).build().map_err(|error| error.to_string())?;
    let (result, seconds) = threads.install(|| {
        let began = Moment::now();
        let result = simplified(&method, &mesh, job, &weights);
        (result, began.seconds(job.threads))
    });
    write_mesh(&job.output, &result?)?;
    Ok(seconds)
}

fn simplified(method: &Method, mesh: &TriMesh, job: &Job, weights: &Loaded) -> Result<TriMesh, String> {
    let mut options = Options::new(Target::Vertices(job.vertices));
    options.seed = job.seed;
    match method {
        Method::Closed => {}
        Method::Network => options.scores = ScoreSource::Network,
        Method::Geometry => options.scores = ScoreSource::Geometry,
        Method::Mean => options.optimize = Optimize::Mean,
        Method::Max => options.optimize = Optimize::Max,
        Method::Normals => options.optimize = Optimize::Normals,
        Method::Fast => options.effort = Effort::Fast,
        Method::Best => options.effort = Effort::Best,
        Method::BestMean => (options.optimize, options.effort) = (Optimize::Mean, Effort::Best),
        Method::Paper => options.assembly = Assembly::Paper,
        Method::PaperClosed => (options.assembly, options.close) = (Assembly::Paper, true),
        Method::Baseline(baseline) => {
            let size = Size { vertices: job.vertices, faces: job.faces };
            return simplify_by(*baseline, mesh, size, job.seed).map_err(|error| error.to_string());
        }
        Method::Learned(baseline) => {
            let weights = weights.learned.as_ref().unwrap_or_else(|| LearnedWeights::shipped(*baseline));
            let simplified = simplify_by_learned(weights, mesh, job.vertices, job.seed);
            return simplified.map_err(|error| error.to_string());
        }
        Method::Tool(tool) => return Err(format!("{} is a program of its own", tool.name)),
    }
    let simplified = simplify(mesh, weights.ours.as_ref(), &options, &mut |_| ControlFlow::Continue(()));
    simplified.map(|simplified| simplified.mesh).map_err(|error| error.to_string())
}

/// Weights from a file, where a job has one.
#[derive(Default)]
struct Loaded {
    ours: Option<Weights>,
    learned: Option<LearnedWeights>,
}

/// The weights of a job. Those that ship are parsed when first asked for, which is done here and not while the clock runs.
fn weights(method: &Method, path: Option<&Path>) -> Result<Loaded, String> {
    let _ = (Weights::shipped_default(), Weights::shipped_paper_open());
    LearnedBaseline::ALL.into_iter().for_each(|baseline| _ = LearnedWeights::shipped(baseline));
    let Some(path) = path else { return Ok(Loaded::default()) };
    let bytes = std::fs::read(path).map_err(|error| format!("{}: cannot be read: {error}", path.display()))?;
    let wrong = |error| format!("{}: {error}", path.display());
    Ok(match method {
        Method::Learned(_) => {
            Loaded { learned: Some(LearnedWeights::from_bytes(&bytes).map_err(wrong)?), ..Loaded::default() }
        }
        _ => Loaded { ours: Some(Weights::from_bytes(&bytes).map_err(wrong)?), ..Loaded::default() },
    })
}

/// Writes a mesh so that [`read_mesh`] gives back its very bits.
pub(super) fn write_mesh(path: &Path, mesh: &TriMesh) -> Result<(), String> {
    let format = Format::from_path(path).unwrap_or(Format::Ply);
    let bytes = write(mesh, &Frame::default(), format).map_err(|error| error.to_string())?;
    write_path(path, &bytes, true).map_err(|error| format!("{}: {error}", path.display()))
}

/// Reads a mesh as [`write_mesh`] has written it, without cleaning.
pub(super) fn read_mesh(path: &Path) -> Result<TriMesh, String> {
    let raw = read_path(path, None).map_err(|error| error.to_string())?;
    let positions = raw.positions.into_iter().map(|position| position.map(|x| x as f32)).collect();
    TriMesh::new(positions, raw.faces).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    #[test]
    fn every_method_answers_with_its_time_and_a_lighter_mesh() {
        let folder = tempfile::tempdir().unwrap();
        let [input, output] = ["in.ply", "out.ply"].map(|name| folder.path().join(name));
        let mesh = shapes::icosphere(3);
        write_mesh(&input, &mesh).unwrap();
        assert_eq!(read_mesh(&input).unwrap(), mesh);
        for method in Method::names() {
            let job = Job {
                input: input.clone(),
                output: output.clone(),
                method: method.into(),
                vertices: 160,
                faces: 316,
                seed: 0,
                weights: None,
                threads: 1,
            };
            let answer = answer(&serde_json::to_string(&Work::Method(job)).unwrap());
            let seconds: Result<f64, String> = serde_json::from_str(&answer).unwrap();
            assert!(seconds.unwrap() > 0.0);
            assert!((50..=200).contains(&read_mesh(&output).unwrap().positions().len()), "{method}");
        }
    }
}
