//! One run of a method of this package, here or in another process.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::clock::Moment;
use super::foreign::{self, ForeignRun};
use super::method::Method;
use crate::baselines::{TargetCounts, simplify_by};
use crate::learned_baselines::{LearnedBaseline, LearnedWeights, simplify_by_learned};
use neural_mesh::io::{Format, read_path, write, write_path};
use neural_mesh::mesh::{Frame, TriMesh, compact};
use neural_mesh::model::Weights;
use neural_mesh::simplify::paper::{orient_triangle, paper_stages};
use neural_mesh::simplify::{
    Assembly, ClosedOptions, Effort, Input, Optimize, Options, PaperOptions, ScoreSource, Size, asked_scores, simplify,
};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Job {
    pub input: PathBuf,
    pub output: PathBuf,
    pub method: String,
    pub vertices: usize,
    pub faces: usize,
    pub seed: u64,
    /// Weights file; shipped weights if `None`.
    pub weights: Option<PathBuf>,
    pub threads: usize,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Work {
    Method(Job),
    Foreign(ForeignRun),
}

/// Runs a job given as a line of JSON; returns its seconds or its error as JSON.
pub fn answer_job(line: &str) -> String {
    let done = match serde_json::from_str(line) {
        Ok(Work::Method(job)) => run_job(&job),
        Ok(Work::Foreign(foreign)) => foreign::run_foreign(&foreign),
        Err(error) => Err(format!("the job is not valid: {error}")),
    };
    serde_json::to_string(&done).unwrap_or_default()
}

/// Runs a job and returns the seconds of the method alone.
pub(super) fn run_job(job: &Job) -> Result<f64, String> {
    let mesh = read_mesh(&job.input)?;
    let method = Method::from_name(&job.method).ok_or_else(|| format!("unknown method {}", job.method))?;
    let weights = load_weights(&method, job.weights.as_deref())?;
    let threads =
        rayon::ThreadPoolBuilder::new().num_threads(job.threads).build().map_err(|error| error.to_string())?;
    let (result, seconds) = threads.install(|| {
        let began = Moment::now();
        let result = run_method(&method, &mesh, job, &weights);
        (result, began.seconds(job.threads))
    });
    write_mesh(&job.output, &result?)?;
    Ok(seconds)
}

fn run_method(method: &Method, mesh: &TriMesh, job: &Job, weights: &JobWeights) -> Result<TriMesh, String> {
    let name = match method {
        Method::Ours(name) => *name,
        Method::Baseline(baseline) => {
            let size = TargetCounts { vertices: job.vertices, faces: job.faces };
            return simplify_by(*baseline, mesh, size, job.seed).map_err(|error| error.to_string());
        }
        Method::Learned(baseline) => {
            let weights = weights.learned.as_ref().unwrap_or_else(|| LearnedWeights::load_shipped(*baseline));
            let simplified = simplify_by_learned(weights, mesh, job.vertices, job.seed);
            return simplified.map_err(|error| error.to_string());
        }
        Method::Tool(tool) => return Err(format!("{} is an external tool and cannot run in the worker", tool.name)),
    };
    if name == "paper-quotient" {
        return span_regions(mesh, job, weights.ours.clone());
    }
    let mut options = options(name, Size::Vertices(job.vertices), job.seed);
    if let Assembly::Paper(paper) = &mut options.assembly {
        paper.weights = weights.ours.clone().map(Arc::new);
    }
    let source = match options.assembly.as_closed() {
        Some(closed) if weights.ours.is_none() || closed.scores == ScoreSource::Geometry => closed.scores,
        Some(_) => ScoreSource::Network,
        None => ScoreSource::Geometry,
    };
    let scores = asked_scores(source, mesh, weights.ours.as_ref());
    let mut input = Input::bare(mesh);
    input.scores = &scores;
    let simplified = simplify(input, &options, &mut |_| ControlFlow::Continue(()));
    simplified.map(|simplified| simplified.mesh).map_err(|error| error.to_string())
}

/// Joins the paper's samples where three of their regions meet, without Edge Predictor and Face Classifier.
fn span_regions(mesh: &TriMesh, job: &Job, weights: Option<Weights>) -> Result<TriMesh, String> {
    let options = PaperOptions { weights: weights.map(Arc::new), seed: job.seed, ..PaperOptions::default() };
    let stages = paper_stages(mesh, job.vertices, &options, &mut |_| ControlFlow::Continue(()));
    let stages = stages.map_err(|error| error.to_string())?;
    let samples: Vec<[f32; 3]> = stages.samples.iter().map(|&v| mesh.positions()[v as usize]).collect();
    let faces = stages.quotient.triangles.iter().map(|&face| orient_triangle(face, &samples, &stages.quotient));
    compact(&samples, faces.collect()).map(|(mesh, _)| mesh).map_err(|error| error.to_string())
}

fn options(name: &str, target: Size, seed: u64) -> Options {
    let default = ClosedOptions::default();
    let paper =
        |close, place| Options::with_paper(target, PaperOptions { seed, close, place, ..PaperOptions::default() });
    let closed = match name {
        "paper" => return paper(false, false),
        "paper-closed" => return paper(true, false),
        "paper-placed" => return paper(true, true),
        "network" => ClosedOptions { scores: ScoreSource::Network, ..default },
        "geometry" => ClosedOptions { scores: ScoreSource::Geometry, ..default },
        "mean" => ClosedOptions { optimize: Optimize::Mean, ..default },
        "max" => ClosedOptions { optimize: Optimize::Max, ..default },
        "normals" => ClosedOptions { optimize: Optimize::Normals, ..default },
        "looks" => ClosedOptions { optimize: Optimize::Looks, ..default },
        "fast" => ClosedOptions { effort: Effort::Fast, ..default },
        "best" => ClosedOptions { effort: Effort::Best, ..default },
        "best-mean" => ClosedOptions { optimize: Optimize::Mean, effort: Effort::Best, ..default },
        _ => default,
    };
    Options::with_closed(target, closed)
}

#[derive(Default)]
struct JobWeights {
    ours: Option<Weights>,
    learned: Option<LearnedWeights>,
}

fn load_weights(method: &Method, path: Option<&Path>) -> Result<JobWeights, String> {
    // All shipped weights are parsed before the clock starts.
    let _ = (Weights::shipped_default(), Weights::shipped_paper_open());
    LearnedBaseline::ALL.into_iter().for_each(|baseline| _ = LearnedWeights::load_shipped(baseline));
    let Some(path) = path else { return Ok(JobWeights::default()) };
    let bytes = std::fs::read(path).map_err(|error| format!("{}: cannot be read: {error}", path.display()))?;
    let wrong = |error| format!("{}: {error}", path.display());
    Ok(match method {
        Method::Learned(_) => {
            JobWeights { learned: Some(LearnedWeights::from_bytes(&bytes).map_err(wrong)?), ..JobWeights::default() }
        }
        _ => JobWeights { ours: Some(Weights::from_bytes(&bytes).map_err(wrong)?), ..JobWeights::default() },
    })
}

/// Writes a mesh so that [`read_mesh`] returns the same bits.
pub(super) fn write_mesh(path: &Path, mesh: &TriMesh) -> Result<(), String> {
    let format = Format::from_path(path).unwrap_or(Format::Ply);
    let bytes = write(mesh, &Frame::default(), format).map_err(|error| error.to_string())?;
    write_path(path, &bytes, true).map_err(|error| format!("{}: {error}", path.display()))
}

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
        assert!(answer_job("no work").starts_with("{\"Err\":"));
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
            let answer = answer_job(&serde_json::to_string(&Work::Method(job)).unwrap());
            let seconds: Result<f64, String> = serde_json::from_str(&answer).unwrap();
            assert!(seconds.unwrap() > 0.0);
            assert!((50..=200).contains(&read_mesh(&output).unwrap().positions().len()), "{method}");
        }
    }
}
