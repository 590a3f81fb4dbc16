//! Report of a job, as the JSON of `--report`.

use crate::mesh::cleanup::CleanCounts;
use crate::mesh::{TriMesh, topology};
use crate::metrics::{CertifiedDistance, QuickDistance};
use crate::repair::RepairCounts;
use crate::simplify::{Outcome, ScoreSource};
use serde::Serialize;
use serde_json::{Map, Value};

use super::baked_material::BakeFigures;
use super::size::Goal;

/// Report of a job.
#[derive(Debug, Serialize)]
pub struct JobReport {
    /// MeshSize of the input after cleaning.
    pub input: MeshSize,
    /// Figures of the written mesh.
    pub output: OutputFigures,
    /// Requested size.
    pub target: Goal,
    /// `reached`, or `stopped: ` and the reason.
    pub outcome: String,
    /// Source of the scores: `bending`, `geometry` or `network`.
    pub scores: &'static str,
    /// Seed of the sampling.
    pub seed: u64,
    /// Number of threads.
    pub threads: usize,
    /// Seconds per stage.
    pub seconds: Seconds,
    /// Changes made by cleaning.
    pub cleaned: CleanCounts,
    /// Changes made by `--fill-holes` or `--printable`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repaired: Option<RepairCounts>,
    /// Figures of `--bake`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baked: Option<BakeFigures>,
    /// Results of each `--ratio NAME=SHARE`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub named: Vec<NamedShare>,
    /// Distance from the original; `null` with `--no-check`.
    pub distance: Option<DistanceFigures>,
    /// Proved bounds of the largest distance, with `--error`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified: Option<Certified>,
    /// Levels of detail; `output` is the first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub levels: Vec<Level>,
    /// Lost or repaired content, one line each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Options that would allow a smaller result, one line each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub free: Vec<String>,
}

/// One level of detail.
#[derive(Clone, Debug, Serialize)]
pub struct Level {
    /// Figures of the written mesh.
    #[serde(flatten)]
    pub output: OutputFigures,
    /// `reached`, or `stopped: ` and the reason.
    pub outcome: String,
    /// Distance from the original; `null` with `--no-check`.
    pub distance: Option<DistanceFigures>,
    /// Share of the screen's height at which the largest error is one pixel of 1080 lines, at most 1.
    ///
    /// The error is the proved one, or else the sampled one; `null` without either.
    pub screen_coverage: Option<f64>,
    /// Distance to the viewer from which this error is at most a pixel, in the unit of the mesh.
    pub switch_distance: Option<f64>,
    /// Proved bounds of the largest distance, for levels by distance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified: Option<Certified>,
}

/// Outcome of a run that met its goal.
pub const REACHED: &str = "reached";
const STOPPED: &str = "stopped: ";

const SCREEN_LINES: f64 = 1080.0;

impl Level {
    /// Makes a level whose errors on a screen are unknown.
    pub fn new(output: OutputFigures, outcome: String, distance: Option<DistanceFigures>) -> Self {
        Self { output, outcome, distance, screen_coverage: None, switch_distance: None, certified: None }
    }

    /// Sets from where the level may be drawn, for a mesh with this diagonal and a field of view in degrees.
    pub(super) fn set_view(&mut self, diagonal: impl Fn() -> f64, field_of_view: f64) {
        let proved = self.certified.map(|certified| certified.upper_percent);
        let Some(percent) = proved.or(self.distance.map(|distance| distance.max_percent)) else { return };
        let error = percent / 100.0;
        // A unit at the distance 1 covers this many lines of the screen.
        let lines = SCREEN_LINES / (2.0 * (0.5 * field_of_view.to_radians()).tan());
        (self.screen_coverage, self.switch_distance) =
            (Some((1.0 / (error * SCREEN_LINES)).min(1.0)), Some(error * diagonal() * lines));
    }
}

/// Bounds of the largest two-sided distance.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Certified {
    /// Lower bound, in the unit of the mesh.
    pub lower: f64,
    /// Upper bound, in the unit of the mesh.
    pub upper: f64,
    /// Lower bound in percent of the diagonal.
    pub lower_percent: f64,
    /// Upper bound in percent of the diagonal.
    pub upper_percent: f64,
}

impl Certified {
    /// Converts a proved distance; if the diagonal is 0, percents are in the unit of the mesh.
    pub fn new(distance: &CertifiedDistance, diagonal: f64) -> Self {
        let percent = if diagonal > 0.0 { 100.0 / diagonal } else { 1.0 };
        let CertifiedDistance { lower, upper, .. } = *distance;
        Self { lower, upper, lower_percent: lower * percent, upper_percent: upper * percent }
    }
}

/// Content of the file that `--map` writes; vertices are those of the cleaned mesh and of the result.
#[derive(Debug, Serialize)]
pub struct MapFile<'a> {
    /// File vertex (from 0) of each input vertex; missing for a scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file_vertices: Option<&'a [u32]>,
    /// Output vertex of each input vertex; `null` if dropped.
    pub output_vertices: Vec<Option<u32>>,
    /// Input vertex nearest to each output vertex.
    pub input_vertices: &'a [u32],
    /// Input face below each corner of the output's faces.
    pub corner_faces: &'a [[u32; 3]],
    /// Barycentric weights in that face.
    pub corner_weights: &'a [[[f32; 3]; 3]],
}

impl<'a> MapFile<'a> {
    /// Makes the content from the map of a result.
    pub fn new(map: &'a crate::simplify::Map, file_vertices: Option<&'a [u32]>) -> Self {
        Self {
            file_vertices,
            output_vertices: map.output_vertices.iter().map(|&x| Some(x).filter(|&x| x != u32::MAX)).collect(),
            input_vertices: &map.input_vertices,
            corner_faces: &map.corner_faces,
            corner_weights: &map.corner_weights,
        }
    }
}

/// MeshSize and topology of a mesh.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct MeshSize {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
    /// Topology, if requested.
    #[serde(flatten)]
    pub shape: Option<Shape>,
}

/// Topology of a mesh.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Shape {
    /// True if no edge has only one face.
    pub closed: bool,
    /// Edges with one face.
    pub boundary_edges: usize,
    /// Edges with more than two faces.
    pub non_manifold_edges: usize,
    /// Vertices whose faces form several fans.
    pub non_manifold_vertices: usize,
    /// Components.
    pub components: usize,
    /// Euler characteristic.
    pub euler: i64,
}

/// Result and its relation to the input.
#[derive(Clone, Debug, Serialize)]
pub struct OutputFigures {
    /// MeshSize and topology.
    #[serde(flatten)]
    pub size: MeshSize,
    /// Number of vertices in the file, with copies at seams; missing for STL, and if nothing is written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertices_written: Option<usize>,
    /// Number of components that cannot shrink: tetrahedra and single triangles.
    pub components_at_minimum: usize,
    /// Numbers of vertices and faces at which shapes are kept, if the result is smaller.
    ///
    /// Shapes are kept within about 1 % of the diagonal; for single surfaces the size is an estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_with_shape: Option<(usize, usize)>,
    /// Number of dropped components.
    pub components_pruned: usize,
    /// Number of components dropped by `--hidden drop`.
    pub components_hidden: usize,
    /// Dropped components, in the order of the input's faces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub dropped: Vec<Dropped>,
    /// Feature edges of the input.
    pub kept_edges: usize,
    /// Locked vertices of the input.
    pub locked_vertices: usize,
    /// Input vertices and edges split because several sheets met there.
    pub split_vertices: usize,
    /// Flipped edges.
    pub flipped_edges: usize,
    /// Vertices moved apart because their written positions would be equal.
    pub separated_vertices: usize,
    /// Spikes, vertices much farther from the original than their neighbours, that were moved back toward it.
    pub shortened_spikes: usize,
}

/// Result of `--ratio NAME=SHARE` for one name.
#[derive(Clone, Debug, Serialize)]
pub struct NamedShare {
    /// Name of the material, group or object.
    pub name: String,
    /// Requested share of the vertices.
    pub ratio: f64,
    /// Faces with the name in the input.
    pub faces_before: usize,
    /// Faces with the name in the result.
    pub faces: usize,
}

/// Dropped component.
#[derive(Clone, Debug, Serialize)]
pub struct Dropped {
    /// Name of its mesh or object, and material.
    pub name: String,
    /// Number of faces.
    pub faces: usize,
}

/// Wall-clock seconds; set by the caller.
#[derive(Debug, Default, Serialize)]
pub struct Seconds {
    /// Seconds from opening the input to arrays.
    pub read: f64,
    /// Seconds from arrays to the simplified mesh.
    pub simplify: f64,
    /// Seconds from the simplified mesh to bytes on disk.
    pub write: f64,
    /// Seconds of measuring input and output.
    pub check: f64,
    /// Seconds from the simplified mesh to baked textures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bake: Option<f64>,
    /// Seconds of drawing the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<f64>,
    /// Seconds per stage of `simplify`, by name, in order.
    pub stages: Map<String, Value>,
}

/// Samples on each surface: enough for a mean distance within 1 %.
pub const SAMPLES: usize = 8000;

/// Two-sided distance in percent of the original's bounding box diagonal.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct DistanceFigures {
    /// Mean of both directions.
    pub mean_percent: f64,
    /// Largest sampled distance, a lower bound of the true one.
    pub max_percent: f64,
    /// Samples on each surface.
    pub samples: usize,
}

impl MeshSize {
    /// Measures a mesh without unused vertices.
    pub fn measure(mesh: &TriMesh, with_shape: bool) -> Self {
        let shape = with_shape.then(|| Shape::measure(mesh));
        Self { vertices: mesh.positions().len(), faces: mesh.faces().len(), shape }
    }
}

impl Shape {
    fn measure(mesh: &TriMesh) -> Self {
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

impl OutputFigures {
    /// Makes the figures from the simplifier's report.
    pub fn new(size: MeshSize, done: &crate::simplify::Report) -> Self {
        Self {
            size,
            vertices_written: None,
            components_at_minimum: done.components_at_minimum,
            size_with_shape: done.size_with_shape,
            components_pruned: done.components_pruned,
            components_hidden: done.components_hidden,
            dropped: Vec::new(),
            kept_edges: done.kept_edges,
            locked_vertices: done.locked_vertices,
            split_vertices: done.split_vertices,
            flipped_edges: done.flipped_edges,
            separated_vertices: done.separated_vertices,
            shortened_spikes: done.shortened_spikes,
        }
    }
}

impl DistanceFigures {
    /// Converts distances to percent of the diagonal; if the diagonal is 0, distances stay absolute.
    pub fn new(measured: &QuickDistance) -> Self {
        let percent = if measured.diagonal > 0.0 { 100.0 / measured.diagonal } else { 1.0 };
        Self { mean_percent: measured.mean * percent, max_percent: measured.max * percent, samples: measured.n_samples }
    }
}

/// Returns the name of the scores' source.
pub fn score_words(source: ScoreSource) -> &'static str {
    match source {
        ScoreSource::Bending => "bending",
        ScoreSource::Geometry => "geometry",
        ScoreSource::Network => "network",
    }
}

/// Returns `reached`, or `stopped: ` and the reason.
pub fn outcome_words(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Reached => REACHED.into(),
        Outcome::Stopped(why) => format!("{STOPPED}{why}"),
    }
}

/// Returns the reason after `stopped: `.
pub fn stop_reason(outcome: &str) -> Option<&str> {
    outcome.strip_prefix(STOPPED)
}
