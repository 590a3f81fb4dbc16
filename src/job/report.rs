//! The report of a run, as the JSON that `--report` writes.

use crate::mesh::cleanup::CleanCounts;
use crate::mesh::{TriMesh, topology};
use crate::metrics::{CertifiedDistance, QuickDistance};
use crate::repair::RepairCounts;
use crate::simplify::{Outcome, ScoreSource, Target};
use serde::Serialize;
use serde_json::{Map, Value};

use super::dress::Baked;
use super::size::{Bound, Count, Goal, LevelSize, percent};

/// All that is reported of a run of `simplify`.
#[derive(Debug, Serialize)]
pub struct Report {
    /// The mesh as cleaned.
    pub input: Size,
    /// The mesh as written.
    pub output: Output,
    /// What was asked for.
    pub target: TargetWords,
    /// `reached`, or `stopped: ` and why: a size that was not reached, a bound that is not held.
    pub outcome: String,
    /// `geometry` or `network`.
    pub scores: &'static str,
    /// Seed of the sampling.
    pub seed: u64,
    /// Threads used.
    pub threads: usize,
    /// Where the time went.
    pub seconds: Seconds,
    /// What was cleaned on reading.
    pub cleaned: Cleaned,
    /// What was repaired, where `--fill-holes` or `--printable` asked for that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repaired: Option<Repaired>,
    /// What was baked, where `--bake` asked for that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baked: Option<Baked>,
    /// What became of names that had shares of their own.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub named: Vec<NamedShare>,
    /// Distance from the original; `null` with `--no-check`.
    pub distance: Option<Distance>,
    /// Bounds of the largest distance, where `--error` asked for a proof.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified: Option<Certified>,
    /// The plane that the result is mirrored about, as `x = 0`, where `--symmetric` asked for that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mirror: Option<String>,
    /// The levels of detail, where these were asked for; `output` is the first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub levels: Vec<Level>,
    /// What could not be kept, and what had to be mended, in one line each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Options that free what holds a result which was to be smaller, in one line each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub free: Vec<String>,
}

/// A result among several.
#[derive(Clone, Debug, Serialize)]
pub struct Level {
    /// The mesh as written.
    #[serde(flatten)]
    pub output: Output,
    /// `reached`, or `stopped: ` and why: a size that was not reached, a bound that is not held.
    pub outcome: String,
    /// Distance from the original; `null` with `--no-check`.
    pub distance: Option<Distance>,
    /// Share of the screen's height that the whole mesh may take for its largest error to stay below a pixel of 1080 lines;
    /// at most 1. `null` with `--no-check`.
    pub screen_coverage: Option<f64>,
    /// Bounds of the largest distance, where levels by distance asked for a proof.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified: Option<Certified>,
}

/// The outcome where what was asked is held.
pub const REACHED: &str = "reached";
/// How it begins where that is not so.
const STOPPED: &str = "stopped: ";

/// Lines of the screen that levels of detail are chosen for.
const SCREEN_LINES: f64 = 1080.0;

impl Level {
    /// With the coverage that follows from the distance.
    pub fn new(output: Output, outcome: String, distance: Option<Distance>) -> Self {
        let coverage = |distance: Distance| (100.0 / distance.max_percent / SCREEN_LINES).min(1.0);
        Self { output, outcome, distance, screen_coverage: distance.map(coverage), certified: None }
    }
}

/// Bounds of the largest distance in either direction, in the unit of the mesh and in percent of its diagonal.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Certified {
    /// Some point is at least so far.
    pub lower: f64,
    /// No point is farther.
    pub upper: f64,
    /// The same in percent.
    pub lower_percent: f64,
    /// The same in percent.
    pub upper_percent: f64,
}

impl Certified {
    /// In both units; in percent of nothing, both are the same. `diagonal` is that of the input, of which less may have been compared.
    pub fn of(distance: &CertifiedDistance, diagonal: f64) -> Self {
        let percent = if diagonal > 0.0 { 100.0 / diagonal } else { 1.0 };
        let CertifiedDistance { lower, upper, .. } = *distance;
        Self { lower, upper, lower_percent: lower * percent, upper_percent: upper * percent }
    }
}

/// What `--map` writes; vertices are numbered as in the cleaned mesh and in the result.
#[derive(Debug, Serialize)]
pub struct MapFile<'a> {
    /// The vertex of the file (from 0) that each input vertex was read from; missing for a scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file_vertices: Option<&'a [u32]>,
    /// The output vertex that each input vertex went into; `null` where it was dropped.
    pub output_vertices: Vec<Option<u32>>,
    /// The input vertex nearest to each output vertex.
    pub input_vertices: &'a [u32],
    /// For each corner of the output's faces the input face that it stands on.
    pub corner_faces: &'a [[u32; 3]],
    /// The weights of that face's corners.
    pub corner_weights: &'a [[[f32; 3]; 3]],
}

impl<'a> MapFile<'a> {
    /// From the map of a result.
    pub fn of(map: &'a crate::simplify::Map, file_vertices: Option<&'a [u32]>) -> Self {
        Self {
            file_vertices,
            output_vertices: map.output_vertices.iter().map(|&x| Some(x).filter(|&x| x != u32::MAX)).collect(),
            input_vertices: &map.input_vertices,
            corner_faces: &map.corner_faces,
            corner_weights: &map.corner_weights,
        }
    }
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
#[derive(Clone, Debug, Serialize)]
pub struct Output {
    /// The figures of the mesh.
    #[serde(flatten)]
    pub size: Size,
    /// Vertices of the file: those at seams as often as their values differ. Missing where nothing is written and for STL, whose
    /// faces share none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertices_written: Option<usize>,
    /// Components in their smallest closed form.
    pub components_at_minimum: usize,
    /// Whether a smaller result would take the shape of a component.
    pub components_keep_shape: bool,
    /// Components dropped.
    pub components_pruned: usize,
    /// How many of these `--hidden drop` named.
    pub components_hidden: usize,
    /// The components dropped, in the order of the input's faces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub dropped: Vec<Dropped>,
    /// Edges of the input that had to stay edges: seams, boundaries between materials, creases.
    pub kept_edges: usize,
    /// Vertices of the input that had to stay where they are.
    pub locked_vertices: usize,
    /// Vertices and edges of the input cut because more than one sheet met there.
    pub split_vertices: usize,
    /// Edges that gave way to the other diagonal of their faces.
    pub flipped_edges: usize,
    /// Vertices moved apart because their written positions would have been the same.
    pub separated_vertices: usize,
}

/// What became of a name with a share of its own.
#[derive(Clone, Debug, Serialize)]
pub struct NamedShare {
    /// The name.
    pub name: String,
    /// Share of the vertices that was asked for.
    pub ratio: f64,
    /// Its faces in the input.
    pub faces_before: usize,
    /// Its faces in the result.
    pub faces: usize,
}

/// A component that was dropped.
#[derive(Clone, Debug, Serialize)]
pub struct Dropped {
    /// The mesh of the scene, or the object, and its material; as far as the file names them.
    pub name: String,
    /// Faces that it had.
    pub faces: usize,
}

/// What was asked for: `{"ratio": 0.1}`, `{"vertices": 100}`, `{"faces": 100}`, `{"faces_percent": 10.0}`, `{"error": 0.01}`, `{"error_percent": 0.5}`,
/// `{"bytes": 500000}`, `{"lods": [0.5, 0.1]}`, `{"lods_faces": ["20000", "10%"]}`, `{"lods_vertices": ["20000"]}` or `{"lods_error": ["0.1%"]}`.
#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TargetWords {
    /// Share of the vertices.
    Ratio(f64),
    /// Number of vertices.
    Vertices(usize),
    /// Number of faces.
    Faces(usize),
    /// Share of the faces in percent.
    FacesPercent(f64),
    /// Largest distance in the unit of the mesh.
    Error(f64),
    /// Largest distance in percent of the diagonal.
    ErrorPercent(f64),
    /// Bytes of the file.
    Bytes(usize),
    /// Shares of the vertices, level by level.
    Lods(Vec<f64>),
    /// Numbers of vertices or shares of them, level by level.
    LodsVertices(Vec<String>),
    /// Numbers of faces or shares of them, level by level.
    LodsFaces(Vec<String>),
    /// Largest distances, in the unit of the mesh or in percent of the diagonal, level by level.
    LodsError(Vec<String>),
}

/// What was asked for.
pub fn target_words(goal: &Goal, first: Target) -> TargetWords {
    match goal {
        Goal::Target => first.into(),
        Goal::ShareOfFaces(share) => TargetWords::FacesPercent(percent(*share)),
        Goal::Error(Bound::Absolute(error)) => TargetWords::Error(*error),
        Goal::Error(Bound::Percent(percent)) => TargetWords::ErrorPercent(*percent),
        Goal::Size(n_bytes) => TargetWords::Bytes(*n_bytes),
        Goal::Levels(sizes) => levels(sizes),
        Goal::ErrorLevels(bounds) => TargetWords::LodsError(bounds.iter().map(Bound::to_string).collect()),
    }
}

/// Returns levels of detail, which are of one kind: shares of the vertices as numbers, all others as they are typed.
fn levels(sizes: &[LevelSize]) -> TargetWords {
    let share =
        |size: &LevelSize| if let LevelSize::Vertices(Count::Share(share)) = size { Some(*share) } else { None };
    if let Some(shares) = sizes.iter().map(share).collect() {
        return TargetWords::Lods(shares);
    }
    let words = |size: &LevelSize| match size {
        LevelSize::Vertices(count) | LevelSize::Faces(count) => count.to_string(),
    };
    let words = sizes.iter().map(words).collect();
    if matches!(sizes.first(), Some(LevelSize::Faces(_))) {
        TargetWords::LodsFaces(words)
    } else {
        TargetWords::LodsVertices(words)
    }
}

/// Seconds of wall clock; whoever has a clock fills them in.
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
    /// From the finished mesh to its textures, where these are baked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bake: Option<f64>,
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

/// What a repair did before the mesh was simplified.
#[derive(Debug, Serialize)]
pub struct Repaired {
    /// Loops of the boundary that were closed.
    pub holes_filled: usize,
    /// Loops that were left open.
    pub holes_left: usize,
    /// Faces over holes.
    pub faces_added: usize,
    /// Faces that went.
    pub faces_removed: usize,
    /// Faces that were turned over.
    pub faces_turned: usize,
    /// Components that went.
    pub components_dropped: usize,
    /// Components that came apart from others.
    pub components_added: usize,
    /// Components that were turned over as a whole.
    pub components_flipped: usize,
}

/// Samples on each surface for the distance: enough for its mean within a hundredth.
pub const SAMPLES: usize = 8000;

/// Two-sided distance in percent of the diagonal of the original's bounding box.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Distance {
    /// Mean of both directions.
    pub mean_percent: f64,
    /// Largest found in either direction: the true one is at least this.
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
    pub fn of(size: Size, done: &crate::simplify::Report) -> Self {
        Self {
            size,
            vertices_written: None,
            components_at_minimum: done.components_at_minimum,
            components_keep_shape: done.components_keep_shape,
            components_pruned: done.components_pruned,
            components_hidden: done.components_hidden,
            dropped: Vec::new(),
            kept_edges: done.kept_edges,
            locked_vertices: done.locked_vertices,
            split_vertices: done.split_vertices,
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

impl From<&RepairCounts> for Repaired {
    fn from(counts: &RepairCounts) -> Self {
        Self {
            holes_filled: counts.holes_filled,
            holes_left: counts.holes_left,
            faces_added: counts.faces_added,
            faces_removed: counts.faces_removed,
            faces_turned: counts.faces_turned,
            components_dropped: counts.components_dropped,
            components_added: counts.components_added,
            components_flipped: counts.components_flipped,
        }
    }
}

impl Distance {
    /// In percent of the diagonal; a mesh in one point has none, and its distances stay as they are.
    pub fn of(measured: &QuickDistance) -> Self {
        let percent = if measured.diagonal > 0.0 { 100.0 / measured.diagonal } else { 1.0 };
        Self { mean_percent: measured.mean * percent, max_percent: measured.max * percent, samples: measured.n_samples }
    }
}

/// The word for where the scores came from.
pub fn score_words(source: ScoreSource) -> &'static str {
    match source {
        ScoreSource::Bending => "bending",
        ScoreSource::Geometry => "geometry",
        ScoreSource::Network => "network",
    }
}

/// The words for how it ended: `reached`, or `stopped: ` and why.
pub fn outcome_words(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Reached => REACHED.into(),
        Outcome::Stopped(why) => format!("{STOPPED}{why}"),
    }
}

/// What stopped a run that ended in these words.
pub fn why_stopped(outcome: &str) -> Option<&str> {
    outcome.strip_prefix(STOPPED)
}
