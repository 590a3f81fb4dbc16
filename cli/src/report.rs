//! The report of a run, as the JSON that `--report` writes.

use neural_mesh::mesh::cleanup::CleanCounts;
use neural_mesh::mesh::{TriMesh, topology};
use neural_mesh::metrics::QuickDistance;
use neural_mesh::simplify::{Outcome, ScoreSource, Target};
use serde::Serialize;
use serde_json::{Map, Value};

/// All that is reported of a run of `simplify`.
#[derive(Debug, Serialize)]
pub struct Report {
    /// The mesh as cleaned.
    pub input: Size,
    /// The mesh as written.
    pub output: Output,
    /// What was asked for.
    pub target: TargetWords,
    /// `reached`, or what stopped it.
    pub outcome: String,
    /// `geometry` or `network`.
    pub scores: &'static str,
    /// Samples per vertex asked for, as used.
    pub oversample: f64,
    /// Seed of the sampling.
    pub seed: u64,
    /// Threads used.
    pub threads: usize,
    /// Where the time went.
    pub seconds: Seconds,
    /// What was cleaned on reading.
    pub cleaned: Cleaned,
    /// Distance from the original; `null` with `--no-check`.
    pub distance: Option<Distance>,
}

/// How large a mesh is, and what it is as a surface.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Size {
    /// Vertices that a face uses.
    pub vertices: usize,
    /// Faces.
    pub faces: usize,
    /// The rest, where anyone asks for it: it takes longer than to write the mesh.
    #[serde(flatten)]
    pub shape: Option<Shape>,
}

/// What a mesh is as a surface.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Shape {
    /// Whether no edge has only one face.
    pub closed: bool,
    /// Edges with one face.
    pub boundary_edges: usize,
    /// Edges with more than two faces.
    pub non_manifold_edges: usize,
    /// Vertices where fans of faces only touch.
    pub non_manifold_vertices: usize,
    /// Pieces joined over edges.
    pub components: usize,
    /// Vertices - edges + faces.
    pub euler: i64,
}

/// The result, and what became of the input's parts on the way.
#[derive(Debug, Serialize)]
pub struct Output {
    /// The figures of the mesh.
    #[serde(flatten)]
    pub size: Size,
    /// Vertices left by the one pass, before the collapse.
    pub vertices_after_pass: usize,
    /// Components in their smallest closed form.
    pub components_at_minimum: usize,
    /// Components dropped, with `--prune` only.
    pub components_pruned: usize,
    /// Vertices and edges of the input cut because more than one sheet met there.
    pub split_vertices: usize,
    /// Regions refined to keep the surface a manifold.
    pub refined_regions: usize,
    /// Edges that gave way to the other diagonal of their faces.
    pub flipped_edges: usize,
    /// Vertices moved apart because their written positions would have been the same.
    pub separated_vertices: usize,
}

/// The size asked for: `{"ratio": 0.1}`, `{"vertices": 100}` or `{"faces": 100}`.
#[derive(Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TargetWords {
    /// Share of the vertices.
    Ratio(f64),
    /// Number of vertices.
    Vertices(usize),
    /// Number of faces.
    Faces(usize),
}

/// Seconds of wall clock.
#[derive(Debug, Default, Serialize)]
pub struct Seconds {
    /// From opening the input to parsed arrays.
    pub read: f64,
    /// From parsed arrays, through weld and cleanup, to the finished mesh.
    pub simplify: f64,
    /// From the finished mesh to bytes on the disk.
    pub write: f64,
    /// Measuring input and output.
    pub check: f64,
    /// Parts of `simplify` by name, in order.
    pub stages: Map<String, Value>,
}

/// Faces and vertices that were cleaned.
#[derive(Debug, Serialize)]
pub struct Cleaned {
    welded_vertices: usize,
    unreferenced_vertices: usize,
    degenerate_faces: usize,
    duplicate_faces: usize,
    non_finite_faces: usize,
    out_of_range_faces: usize,
    dropped_faces: usize,
}

/// Two-sided distance in percent of the diagonal of the original's bounding box.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Distance {
    /// Mean of both directions.
    pub mean_percent: f64,
    /// Largest of both directions.
    pub max_percent: f64,
    /// Samples on each surface.
    pub samples: usize,
}

impl Size {
    /// The size of a mesh without unused vertices, with its shape or without.
    pub fn of(mesh: &TriMesh, with_shape: bool) -> Self {
        let shape = with_shape.then(|| Shape::of(mesh));
        Self { vertices: mesh.positions().len(), faces: mesh.faces().len(), shape }
    }
}

impl Shape {
    fn of(mesh: &TriMesh) -> Self {
        let figures = topology(mesh);
        Self {
            closed: figures.closed,
            boundary_edges: figures.boundary_edges,
            non_manifold_edges: figures.non_manifold_edges,
            non_manifold_vertices: figures.non_manifold_vertices,
            components: figures.components,
            euler: figures.euler,
        }
    }
}

impl Output {
    /// The figures of the result.
    pub fn of(size: Size, done: &neural_mesh::simplify::Report) -> Self {
        Self {
            size,
            vertices_after_pass: done.vertices_after_pass,
            components_at_minimum: done.components_at_minimum,
            components_pruned: done.components_pruned,
            split_vertices: done.split_vertices,
            refined_regions: done.refined_regions,
            flipped_edges: done.flipped_edges,
            separated_vertices: done.separated_vertices,
        }
    }
}

impl From<Target> for TargetWords {
    fn from(target: Target) -> Self {
        match target {
            Target::Ratio(ratio) => Self::Ratio(ratio),
            Target::Vertices(n) => Self::Vertices(n),
            Target::Faces(n) => Self::Faces(n),
        }
    }
}

impl From<&CleanCounts> for Cleaned {
    fn from(counts: &CleanCounts) -> Self {
        Self {
            welded_vertices: counts.welded_vertices,
            unreferenced_vertices: counts.unreferenced_vertices,
            degenerate_faces: counts.degenerate_faces,
            duplicate_faces: counts.duplicate_faces,
            non_finite_faces: counts.non_finite_faces,
            out_of_range_faces: counts.out_of_range_faces,
            dropped_faces: counts.dropped_faces,
        }
    }
}

impl Distance {
    /// In percent of the diagonal; a mesh in one point has none, and its distances stay as they are.
    pub fn of(measured: &QuickDistance, samples: usize) -> Self {
        let percent = if measured.diagonal > 0.0 { 100.0 / measured.diagonal } else { 1.0 };
        Self { mean_percent: measured.mean * percent, max_percent: measured.max * percent, samples }
    }
}

/// The word for where the scores came from.
pub fn scores(source: ScoreSource) -> &'static str {
    match source {
        ScoreSource::Geometry => "geometry",
        ScoreSource::Network => "network",
    }
}

/// The words for how it ended.
pub fn outcome(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Reached => "reached".into(),
        Outcome::Stopped(why) => why.clone(),
    }
}

/// Stages with their seconds, in order.
pub fn stages(stages: Vec<(&'static str, f64)>) -> Map<String, Value> {
    stages.into_iter().map(|(name, seconds)| (name.to_string(), Value::from(seconds))).collect()
}
