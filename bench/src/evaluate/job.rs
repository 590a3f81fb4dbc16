//! One run of a method of this package, here or in another process.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, anyhow, bail};
use serde::{Deserialize, Serialize};

use super::foreign::{self, ForeignRun};
use super::method::{Method, options};
use crate::baselines::{TargetCounts, simplify_by};
use crate::clock::measure_time;
use crate::learned_baselines::{LearnedBaseline, LearnedWeights, simplify_by_learned};
use neural_mesh::io::{Format, read_path, write, write_path};
use neural_mesh::mesh::{Frame, TriMesh, compact};
use neural_mesh::model::Weights;
use neural_mesh::simplify::paper::{orient_triangle, paper_stages};
use neural_mesh::simplify::{Assembly, Input, Options, PaperOptions, ScoreSource, Size, asked_scores, simplify};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Job {
    pub input: PathBuf,
    pub output: PathBuf,
    pub method: String,
    pub vertices: usize,
    pub faces: usize,
    pub seed: u64,
    /// Weights file of a method of neural-mesh; shipped weights if `None`.
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
        Ok(Work::Method(job)) => run_job(&job).map_err(|error| error.to_string()),
        Ok(Work::Foreign(foreign)) => foreign::run_foreign(&foreign),
        Err(error) => Err(format!("the job is not valid: {error}")),
    };
    serde_json::to_string(&done).unwrap_or_default()
}

/// Runs a job and returns the seconds of the method alone.
///
/// On one thread this is the processor's time, on several the elapsed time.
fn run_job(job: &Job) -> Result<f64> {
    let mesh = read_mesh(&job.input)?;
    let method = Method::from_name(&job.method).with_context(|| format!("unknown method {}", job.method))?;
    let weights = load_weights(job.weights.as_deref())?;
    let threads = rayon::ThreadPoolBuilder::new().num_threads(job.threads).build()?;
    let (result, seconds) = threads.install(|| measure_time(|| run_method(&method, &mesh, job, weights.as_ref())))?;
    write_mesh(&job.output, &result)?;
    Ok(if job.threads == 1 { seconds.thread } else { seconds.wall })
}

fn run_method(method: &Method, mesh: &TriMesh, job: &Job, weights: Option<&Weights>) -> Result<TriMesh> {
    let name = match method {
        Method::Ours(name) => *name,
        Method::Baseline(baseline) => {
            let size = TargetCounts { vertices: job.vertices, faces: job.faces };
            return simplify_by(*baseline, mesh, size, job.seed);
        }
        Method::Learned(baseline) => {
            let weights = LearnedWeights::load_shipped(*baseline);
            return simplify_by_learned(weights, mesh, job.vertices, job.seed);
        }
        Method::Tool(tool) => bail!("{} is an external tool and cannot run in the worker", tool.name),
    };
    if name == "paper-quotient" {
        return span_regions(mesh, job, weights);
    }
    let options = options(name, Size::Vertices(job.vertices), job.seed);
    simplify_ours(mesh, weights, options)
}

/// Simplifies a mesh by neural-mesh with these weights of the network, whose scores then replace those of the formula.
pub fn simplify_ours(mesh: &TriMesh, weights: Option<&Weights>, mut options: Options) -> Result<TriMesh> {
    let source = match &mut options.assembly {
        Assembly::Paper(paper) => {
            paper.weights = weights.cloned().map(Arc::new);
            ScoreSource::Geometry
        }
        Assembly::Closed(closed) if weights.is_some() && closed.scores == ScoreSource::Bending => ScoreSource::Network,
        Assembly::Closed(closed) => closed.scores,
    };
    let scores = asked_scores(source, mesh, weights);
    let mut input = Input::bare(mesh);
    input.scores = &scores;
    Ok(simplify(input, &options, &mut |_| ControlFlow::Continue(()))?.mesh)
}

/// Joins the paper's samples where three of their regions meet, without Edge Predictor and Face Classifier.
fn span_regions(mesh: &TriMesh, job: &Job, weights: Option<&Weights>) -> Result<TriMesh> {
    let options = PaperOptions { weights: weights.cloned().map(Arc::new), seed: job.seed, ..PaperOptions::default() };
    let stages = paper_stages(mesh, job.vertices, &options, &mut |_| ControlFlow::Continue(()))?;
    let samples: Vec<[f32; 3]> = stages.samples.iter().map(|&v| mesh.positions()[v as usize]).collect();
    let faces = stages.quotient.triangles.iter().map(|&face| orient_triangle(face, &samples, &stages.quotient));
    Ok(compact(&samples, faces.collect())?.0)
}

fn load_weights(path: Option<&Path>) -> Result<Option<Weights>> {
    // All shipped weights are parsed before the clock starts.
    let _ = (Weights::shipped_default(), Weights::shipped_paper_open());
    LearnedBaseline::ALL.into_iter().for_each(|baseline| _ = LearnedWeights::load_shipped(baseline));
    let Some(path) = path else { return Ok(None) };
    let bytes = std::fs::read(path).map_err(|error| anyhow!("{}: cannot be read: {error}", path.display()))?;
    Ok(Some(Weights::from_bytes(&bytes).map_err(|error| anyhow!("{}: {error}", path.display()))?))
}

/// Writes a mesh so that [`read_mesh`] returns the same bits.
pub(super) fn write_mesh(path: &Path, mesh: &TriMesh) -> Result<()> {
    let format = Format::from_path(path).unwrap_or(Format::Ply);
    let bytes = write(mesh, &Frame::default(), format)?;
    write_path(path, &bytes, true).map_err(|error| anyhow!("{}: {error}", path.display()))
}

pub(super) fn read_mesh(path: &Path) -> Result<TriMesh> {
    let raw = read_path(path, None)?;
    let positions = raw.positions.into_iter().map(|position| position.map(|x| x as f32)).collect();
    Ok(TriMesh::new(positions, raw.faces)?)
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
