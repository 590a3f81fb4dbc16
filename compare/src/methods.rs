//! The methods compared: ours from parsed arrays, the other one from the welded mesh that it needs.

use std::ops::ControlFlow;
use std::time::Instant;

use anyhow::Result;
use clap::ValueEnum;
use neural_mesh::baselines::meshoptimizer_faces;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{RawMesh, TriMesh};
use neural_mesh::model::Weights;
use neural_mesh::simplify::{Options, Outcome, ScoreSource, Target, simplify};

/// Who simplifies.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Method {
    Ours,
    Meshoptimizer,
}

impl Method {
    /// The name in the tables; ours without the network's scores is a contestant of its own.
    pub fn name(self, scores: Scores) -> &'static str {
        match (self, scores) {
            (Self::Ours, Scores::Network) => "ours",
            (Self::Ours, Scores::Geometry) => "ours, geometry",
            (Self::Meshoptimizer, _) => "meshoptimizer",
        }
    }
}

/// Where our scores come from.
#[derive(Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum Scores {
    /// From the network that ships.
    #[default]
    Network,
    /// From the geometry alone.
    Geometry,
}

impl From<Scores> for ScoreSource {
    fn from(scores: Scores) -> Self {
        match scores {
            Scores::Network => Self::Network,
            Scores::Geometry => Self::Geometry,
        }
    }
}

/// What of our settings is not the default.
#[derive(Clone, Copy, Default)]
pub struct Ours {
    pub oversample: Option<f64>,
    pub scores: Scores,
    pub seed: u64,
}

/// What a method did.
#[derive(Clone)]
pub struct Done {
    pub mesh: TriMesh,
    pub outcome: String,
    pub vertices_after_pass: Option<usize>,
    pub oversample: Option<f64>,
    pub seconds: f64,
}

impl Done {
    /// A result at the size asked for.
    pub fn reached(mesh: TriMesh, seconds: f64) -> Self {
        Self { mesh, outcome: "reached".to_owned(), vertices_after_pass: None, oversample: None, seconds }
    }

    /// No result, and why.
    pub fn failed(why: &str) -> Self {
        let outcome = format!("failed: {why}");
        Self { mesh: TriMesh::default(), outcome, vertices_after_pass: None, oversample: None, seconds: 0.0 }
    }
}

/// neural-mesh with the weights that ship, from parsed arrays down to a share of the vertices.
pub fn ours(raw: &RawMesh, ratio: f64, Ours { oversample, scores, seed }: Ours) -> Result<Done> {
    let scores = scores.into();
    simplified(raw, None, Options { oversample, scores, seed, ..Options::new(Target::Ratio(ratio)) })
}

/// neural-mesh with these weights and options, from parsed arrays.
pub fn simplified(raw: &RawMesh, weights: Option<&Weights>, options: Options) -> Result<Done> {
    let raw = raw.clone();
    let start = Instant::now();
    let cleaned = clean(raw, &CleanOptions::default())?;
    let options = Options { frame: cleaned.frame, ..options };
    let simplified = simplify(&cleaned.mesh, weights, &options, &mut |_| ControlFlow::Continue(()))?;
    let seconds = start.elapsed().as_secs_f64();
    let outcome = match simplified.report.outcome {
        Outcome::Reached => "reached".to_owned(),
        Outcome::Stopped(why) => why,
    };
    Ok(Done {
        mesh: simplified.mesh,
        outcome,
        vertices_after_pass: Some(simplified.report.vertices_after_pass),
        oversample: Some(simplified.report.oversample),
        seconds,
    })
}

/// meshoptimizer's `simplify` without options or error limit, down to a number of faces; the time is that of the call.
pub fn meshoptimizer(mesh: &TriMesh, n_faces: usize) -> Result<Done> {
    let start = Instant::now();
    let faces = meshoptimizer_faces(mesh, n_faces);
    let seconds = start.elapsed().as_secs_f64();
    let mesh = compact(mesh, &faces)?;
    let outcome = if mesh.faces().len() <= n_faces { "reached" } else { "stopped" };
    Ok(Done { mesh, outcome: outcome.to_owned(), vertices_after_pass: None, oversample: None, seconds })
}

/// The faces with the vertices they use.
pub fn compact(mesh: &TriMesh, faces: &[[u32; 3]]) -> Result<TriMesh> {
    let mut new_idx = vec![u32::MAX; mesh.positions().len()];
    let mut positions = Vec::new();
    let mut renumber = |v: u32| {
        let new = &mut new_idx[v as usize];
        if *new == u32::MAX {
            *new = positions.len() as u32;
            positions.push(mesh.positions()[v as usize]);
        }
        *new
    };
    let faces = faces.iter().map(|face| face.map(&mut renumber)).collect();
    Ok(TriMesh::new(positions, faces)?)
}
