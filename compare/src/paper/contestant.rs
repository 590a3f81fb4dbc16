//! Who makes the results of the paper's table.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use neural_mesh::io::read_path;
use neural_mesh::mesh::TriMesh;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::model::{PredictedFaces, Weights, candidate_faces, in_edge_lengths};
use neural_mesh::simplify::paper::{assign_to_samples, choose_faces, oriented, quotient, simplify_paper};
use neural_mesh::simplify::{edge_graph, gumbel_top_k, network_scores, scattered_samples};
use serde::Deserialize;

use crate::methods::{Done, compact, meshoptimizer};
use crate::samplers::farthest::farthest_points;
use crate::samplers::metric::edge_lengths;
use crate::table;

/// A way to come to a lighter mesh.
pub enum Contestant<'a> {
    /// The input itself with other samples: what the figures are of a perfect result.
    Input,
    /// The paper's pipeline.
    Network(&'a Weights),
    /// The triangles between the regions of samples that the network drew, all of them: what a classifier without
    /// errors would leave.
    NetworkQuotient(&'a Weights),
    /// The same of vertices drawn evenly, each by itself.
    UniformQuotient,
    /// The same of vertices drawn evenly and apart from each other, as the network's are.
    ScatteredQuotient,
    /// The same of farthest points along the edges.
    FarthestQuotient,
    /// Results in a folder.
    Qem(&'a Path),
    /// `simplify` of meshoptimizer.
    Meshoptimizer,
}

impl<'a> Contestant<'a> {
    /// Those that can be measured with what is given.
    pub fn all(weights: Option<&'a Weights>, qem: Option<&'a Path>, network_only: bool) -> Vec<Self> {
        let network = weights.into_iter().flat_map(|weights| [Self::Network(weights), Self::NetworkQuotient(weights)]);
        let others =
            [Self::UniformQuotient, Self::ScatteredQuotient, Self::FarthestQuotient, Self::Meshoptimizer, Self::Input];
        let others = others.into_iter().filter(|_| !network_only);
        network.chain(others).chain(qem.map(Self::Qem)).collect()
    }

    /// The name in the tables.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Input => "input",
            Self::Network(_) => "network",
            Self::NetworkQuotient(_) => "network quotient",
            Self::UniformQuotient => "uniform quotient",
            Self::ScatteredQuotient => "scattered quotient",
            Self::FarthestQuotient => "farthest quotient",
            Self::Qem(_) => "qem",
            Self::Meshoptimizer => "meshoptimizer",
        }
    }

    /// Whether another seed gives another result.
    pub fn is_random(&self) -> bool {
        !matches!(self, Self::Input | Self::Qem(_) | Self::Meshoptimizer)
    }

    /// Simplifies `mesh`, whose vertices are all used and whose name is given, to a share of its vertices.
    pub fn simplify(&self, mesh: &TriMesh, name: &str, ratio: f64, seed: u64) -> Result<Done> {
        let n_samples = asked(mesh, ratio);
        let start = Instant::now();
        let faces = match self {
            Self::Input => mesh.faces().to_vec(),
            Self::Network(weights) => {
                simplify_paper(mesh, n_samples, weights, seed, &mut |_| ControlFlow::Continue(()))?.faces
            }
            Self::NetworkQuotient(weights) => {
                spanned(mesh, &scattered(mesh, &network_scores(mesh, weights), n_samples, seed))
            }
            Self::UniformQuotient => spanned(mesh, &gumbel_top_k(&even(mesh), n_samples, seed)),
            Self::ScatteredQuotient => spanned(mesh, &scattered(mesh, &even(mesh), n_samples, seed)),
            Self::FarthestQuotient => spanned(mesh, &farthest(mesh, n_samples, seed)),
            Self::Qem(folder) => return qem(folder, name, ratio),
            Self::Meshoptimizer => {
                return meshoptimizer(mesh, (mesh.faces().len() as f64 * ratio).round() as usize);
            }
        };
        let seconds = start.elapsed().as_secs_f64();
        Ok(Done::reached(compact(mesh, &faces)?, seconds))
    }
}

/// Vertices that stay.
pub fn asked(mesh: &TriMesh, ratio: f64) -> usize {
    (mesh.positions().len() as f64 * ratio) as usize
}

/// The same score for every vertex.
pub fn even(mesh: &TriMesh) -> Vec<f32> {
    vec![0.0; mesh.positions().len()]
}

/// Vertices drawn by their scores, apart from each other, as the pipeline draws them.
pub fn scattered(mesh: &TriMesh, scores: &[f32], n: usize, seed: u64) -> Vec<u32> {
    let rings = edge_graph(mesh);
    scattered_samples(&in_edge_lengths(mesh.positions(), &rings), &rings, scores, n, seed)
}

/// Farthest points along the edges; the seed draws the first.
pub fn farthest(mesh: &TriMesh, n: usize, seed: u64) -> Vec<u32> {
    let first = gumbel_top_k(&even(mesh), 1, seed);
    let mut samples = first.first().map_or(Vec::new(), |&first| farthest_points(&edge_lengths(mesh, 0.0), n, first));
    samples.sort_unstable();
    samples
}

/// The paper's assembly with the triangles between regions as certain faces, those with opposite copies left out.
fn spanned(mesh: &TriMesh, samples: &[u32]) -> Vec<[u32; 3]> {
    let assignment = assign_to_samples(mesh.positions(), &edge_graph(mesh), samples);
    let quotient = quotient(mesh.positions(), mesh.faces(), &assignment, samples.len());
    let kept = quotient.triangles.iter().zip(&quotient.turns).filter(|(_, turns)| **turns != 0);
    let kept: Vec<[u32; 3]> = kept.map(|(triangle, _)| *triangle).collect();
    let n_entries = quotient.edges.n_entries();
    let candidates = candidate_faces(&quotient.edges, &vec![0.0; n_entries], &kept);
    let n = candidates.triangles.len();
    let faces = PredictedFaces { candidates, prior: vec![1.0; n], probabilities: vec![1.0; n] };
    let sampled: Vec<[f32; 3]> = samples.iter().map(|&v| mesh.positions()[v as usize]).collect();
    let chosen = choose_faces(&faces, n_entries).into_iter().map(|at| faces.candidates.triangles[at]);
    let turned = chosen.map(|triangle| oriented(triangle, &sampled, &quotient));
    turned.map(|face| face.map(|sample| samples[sample as usize])).collect()
}

/// A line of the times beside QEM's results.
#[derive(Deserialize)]
struct QemTime {
    mesh: String,
    ratio: f64,
    seconds: f64,
}

/// A result of QEM from its file, vertices as they are, with the time that was written beside it.
fn qem(folder: &Path, name: &str, ratio: f64) -> Result<Done> {
    let path: PathBuf = folder.join(format!("{name}-{ratio}.ply"));
    let raw = read_path(&path, None).with_context(|| format!("{}: run scripts/qem_open3d.py", path.display()))?;
    let mesh = clean(raw, &CleanOptions { weld: false })?.mesh;
    let times: Vec<QemTime> = table::read(&folder.join("times.csv"))?;
    let time = times.iter().find(|time| time.mesh == name && time.ratio == ratio);
    Ok(Done::reached(mesh, time.map_or(f64::NAN, |time| time.seconds)))
}
