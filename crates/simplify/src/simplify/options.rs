//! Options, results and errors of the simplifier.

use std::ops::ControlFlow;
use std::sync::Arc;

use super::{Draw, Size};
use crate::mesh::value_bytes::{store_choices, store_fields};
use crate::mesh::{Attributes, Frame, TriMesh};
use crate::model::{Weights, paper_weights};

/// Size and method of one simplification.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::simplify::{ClosedOptions, Options, PaperOptions, Size};
/// let target = Size::Ratio(0.1);
/// // Edge collapse over vertices of the input:
/// let closed = Options::with_closed(target, ClosedOptions { subset: true, ..ClosedOptions::default() });
/// // The paper's network, with its holes filled:
/// let paper = Options::with_paper(target, PaperOptions { close: true, ..PaperOptions::default() });
/// assert_eq!(closed.target, paper.target);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// Size of the result.
    pub target: Size,
    /// Method that builds the surface, with its own options.
    pub assembly: Assembly,
}

impl Options {
    /// Returns the closed assembly with its defaults.
    pub fn new(target: Size) -> Self {
        Self::with_closed(target, ClosedOptions::default())
    }

    /// Returns the assembly with its options.
    pub fn with_assembly(target: Size, assembly: Assembly) -> Self {
        Self { target, assembly }
    }

    /// Returns the closed assembly with these options.
    pub fn with_closed(target: Size, options: ClosedOptions) -> Self {
        Self { target, assembly: Assembly::Closed(options) }
    }

    /// Returns the paper's assembly with these options.
    pub fn with_paper(target: Size, options: PaperOptions) -> Self {
        Self { target, assembly: Assembly::Paper(options) }
    }
}

/// Method that builds the surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Assembly {
    /// Edge collapse, flips and fit; the result is closed if the input is closed.
    Closed(ClosedOptions),
    /// The paper's assembly (Sec. 4): faces of probability above 0.5 over input vertices.
    Paper(PaperOptions),
}

impl Assembly {
    /// Returns the options of the closed assembly; `None` for the paper's.
    pub fn as_closed(&self) -> Option<&ClosedOptions> {
        match self {
            Self::Closed(options) => Some(options),
            Self::Paper(_) => None,
        }
    }
}

/// Options of the paper's assembly; end a literal with `..PaperOptions::default()`, as versions may add fields.
#[derive(Clone, Debug, Default, PartialEq)]
// Not `non_exhaustive`, which would forbid such literals to callers.
pub struct PaperOptions {
    /// Weights of the network; those of the paper's training that ship with this crate, if none.
    pub weights: Option<Arc<Weights>>,
    /// Seed of the sampling.
    pub seed: u64,
    /// Way of drawing samples.
    pub draw: Draw,
    /// Closes the holes that the network leaves.
    pub close: bool,
    /// Samples again, more densely where regions have large errors, and moves vertices to the minimum of their region's
    /// quadric.
    pub place: bool,
}

impl PaperOptions {
    /// Returns the weights, or those that ship.
    ///
    /// # Errors
    /// [`SimplifyError::NoWeights`] if none are given and this build has none.
    pub(super) fn used_weights(&self) -> Result<&Weights, SimplifyError> {
        match &self.weights {
            Some(weights) => Ok(weights),
            None => paper_weights().ok_or(SimplifyError::NoWeights),
        }
    }
}

/// Options of the closed assembly; end a literal with `..ClosedOptions::default()`, as versions may add fields.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize), serde(default, deny_unknown_fields))]
// Not `non_exhaustive`, which would forbid such literals to callers.
pub struct ClosedOptions {
    /// Source of the vertex scores.
    pub scores: ScoreSource,
    /// Error measure to optimise.
    pub optimize: Optimize,
    /// Trade-off between time and accuracy.
    pub effort: Effort,
    /// Drops components whose vertices are better spent elsewhere; no effect with `lock_boundaries` or `subset`.
    pub prune: bool,
    /// Largest distance of a component to the rest, in mesh units, at which `prune` may drop it. A finite value also
    /// allows components to be deformed by that distance.
    pub prune_within: f64,
    /// Diagonal of the bounding box, in mesh units, below which components are dropped, except the largest by
    /// area; 0 drops none.
    pub prune_below: f64,
    /// Treatment of surfaces that are invisible from outside.
    pub hidden: Hidden,
    /// Largest deformation of a component, over the diagonal of the mesh or scene, that no requested size may exceed;
    /// `None` for no such limit.
    pub hold_shape: Option<f64>,
    /// Keeps boundary vertices and edges bit for bit.
    pub lock_boundaries: bool,
    /// Restricts output vertices to positions of input vertices.
    pub subset: bool,
    /// Distance that texture seams may move at a low price, as a share of the texture's side; 0 holds seams.
    pub seam_error: f64,
    /// Use of the result.
    pub purpose: Purpose,
    /// Least angle between face normals, in degrees, of edges that are kept as creases.
    pub crease_angle: Option<f32>,
    /// Returns a [`Map`] between input and output.
    pub map: bool,
    /// Origin and precision of coordinates in the written file, where no two vertices may coincide.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub frame: Frame,
}

impl Default for ClosedOptions {
    fn default() -> Self {
        Self {
            scores: ScoreSource::default(),
            optimize: Optimize::default(),
            effort: Effort::default(),
            prune: true,
            prune_within: f64::INFINITY,
            prune_below: 0.0,
            hidden: Hidden::default(),
            hold_shape: None,
            lock_boundaries: false,
            subset: false,
            seam_error: SEAM_ERROR,
            purpose: Purpose::default(),
            crease_angle: None,
            map: false,
            frame: Frame::default(),
        }
    }
}

// The form in saved progressions, which a new field or order changes.
store_fields! {
    ClosedOptions { scores: ScoreSource, optimize: Optimize, effort: Effort, prune: bool, prune_within: f64, prune_below: f64,
        hidden: Hidden, lock_boundaries: bool, subset: bool, seam_error: f64, purpose: Purpose, crease_angle: Option<f32>,
        map: bool, frame: Frame } ..Self::default();
}

store_choices! {
    ScoreSource: [ScoreSource::Bending, ScoreSource::Network, ScoreSource::Geometry];
    Optimize: [Optimize::Balanced, Optimize::Mean, Optimize::Max, Optimize::Normals, Optimize::Looks];
    Effort: [Effort::Fast, Effort::Standard, Effort::Best];
    Hidden: [Hidden::Keep, Hidden::Keep, Hidden::Drop];
    Purpose: [Purpose::Shape, Purpose::Poses];
}

/// Use of a result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize), serde(rename_all = "lowercase"))]
pub enum Purpose {
    /// The shape as it is in the file.
    #[default]
    Shape,
    /// Animation: close to the original in the poses of skin and morph targets, too; without these, in any pose.
    Poses,
}

/// Treatment of surfaces that are invisible from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize), serde(rename_all = "lowercase"))]
pub enum Hidden {
    /// Simplify hidden surfaces like visible ones.
    #[default]
    Keep,
    /// Drop components that are fully hidden; they do not count for the bound of --error.
    Drop,
}

/// Default of [`ClosedOptions::seam_error`]: 16 of 1024 texels.
// On five textured models at four ratios 8 texels give a 1 % larger mean distance, unlimited slack an equal one.
pub const SEAM_ERROR: f64 = 16.0 / 1024.0;

/// Source of the scores; the result has more vertices where scores are larger.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize), serde(rename_all = "lowercase"))]
pub enum ScoreSource {
    /// A formula that puts more vertices where the surface bends.
    #[default]
    Bending,
    /// A trained network: that of [`Input::scores`](super::Input::scores), or else the one that ships.
    Network,
    /// None: all vertices have equal importance.
    Geometry,
}

/// Error measure to optimise (`docs/measured/benchmark.md`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize), serde(rename_all = "lowercase"))]
pub enum Optimize {
    /// Mean distance, largest distance and normals alike.
    #[default]
    Balanced,
    /// Mean distance; uses no scores, takes longer.
    Mean,
    /// Largest distance; takes longer, and the mean distance grows.
    Max,
    /// Normals, which decide the shading; the mean distance grows.
    Normals,
    /// Appearance: surfaces count by how much of them is visible.
    Looks,
}

/// Trade-off between time and accuracy (`docs/measured/benchmark.md`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize), serde(rename_all = "lowercase"))]
pub enum Effort {
    /// Edge collapse only: fastest.
    Fast,
    /// Edge collapse, then moves of vertices and flips of edges toward the original.
    #[default]
    Standard,
    /// Standard with more steps and more sample points; takes about twice as long.
    Best,
}

/// Outcome for the requested size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Requested size reached; the result may have one vertex or face less.
    Reached,
    /// Result larger than the target, or not proved within the requested distance; the text names the obstacle.
    Stopped(String),
}

/// Statistics of one run.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// Outcome for the requested size.
    pub outcome: Outcome,
    /// Source of the vertex scores.
    pub scores: ScoreSource,
    /// Number of components in their smallest form: tetrahedra or single triangles.
    pub components_at_minimum: usize,
    /// Numbers of vertices and faces at which shapes are kept, if the result is smaller.
    ///
    /// Shapes are kept within about 1 % of the diagonal; for single surfaces the size is estimated from the prices of
    /// merges.
    pub size_with_shape: Option<(usize, usize)>,
    /// Number of dropped components.
    pub components_pruned: usize,
    /// Number of dropped components that were hidden.
    pub components_hidden: usize,
    /// Dropped components, ascending by their first face.
    pub dropped: Vec<DroppedComponent>,
    /// Number of feature edges in the input: creases, seams and edges between groups.
    pub kept_edges: usize,
    /// Number of locked input vertices.
    pub locked_vertices: usize,
    /// Number of vertices added where several sheets met at a vertex or edge and were split.
    pub split_vertices: usize,
    /// Number of flipped edges.
    pub flipped_edges: usize,
    /// Number of output vertices moved because their positions coincided.
    pub separated_vertices: usize,
    /// Number of spikes, vertices much farther from the original than their neighbours, that were moved back toward it.
    pub shortened_spikes: usize,
}

/// Dropped input component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct DroppedComponent {
    /// First face in the input.
    pub face: u32,
    /// Number of faces.
    pub n_faces: usize,
}

/// Simplified mesh with its report.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Simplified {
    /// Simplified mesh.
    pub mesh: TriMesh,
    /// Attributes of corners and faces; empty with the paper's assembly.
    pub attributes: Attributes,
    /// Input vertex at the position of each output vertex, if all have one.
    pub source_vertices: Option<Vec<u32>>,
    /// Correspondence with the input, if requested.
    pub map: Option<Map>,
    /// Statistics of the run.
    pub report: Report,
}

/// Correspondence between a result and its input.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Map {
    /// Output vertex into which each input vertex was merged; `u32::MAX` if dropped or on no face.
    pub output_vertices: Vec<u32>,
    /// Nearest input vertex merged into each output vertex.
    pub input_vertices: Vec<u32>,
    /// Input face with the point closest to each output corner, on the corner's side of seams.
    pub corner_faces: Vec<[u32; 3]>,
    /// Barycentric weights, in its face of `corner_faces`, of the point closest to each output corner.
    pub corner_weights: Vec<[[f32; 3]; 3]>,
}

/// Progress of a run.
///
/// Any thread may report, one at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Name of the stage.
    pub stage: &'static str,
    /// Completed share of the stage, in 0..=1; never falls.
    pub done: f32,
    /// Completed share of the run, in 0..=1; never falls.
    pub total: f32,
}

/// Progress callback; `ControlFlow::Break` stops the run.
///
/// The closed assembly stops within about a tenth of a second, the paper's (and any with `panic = "abort"`) at the end
/// of its stage.
pub type Listener<'a> = dyn FnMut(Event) -> ControlFlow<()> + Send + 'a;

/// Reason why there is no result.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SimplifyError {
    /// Mesh without faces.
    Empty,
    /// Too few points for a surface; holds their number.
    TooFewPoints(usize),
    /// Size that is none: zero, not a number, or a ratio above 1.
    BadTarget(Size),
    /// Distance limit that is negative or not a number.
    BadError(f64),
    /// Attributes or importance of wrong length, or factors that are not positive.
    BadInput,
    /// Bytes that are no progression; the text says why.
    BadProgression(&'static str),
    /// Progression without proved distances.
    NotProved,
    /// Factors of wrong number or not positive, or a vertex on no face.
    BadImportance,
    /// No weights for the paper's assembly.
    NoWeights,
    /// No face with a probability above one half.
    NothingKept,
    /// Result coordinates beyond `f32`.
    Overflow,
    /// Run stopped by the progress callback.
    Interrupted,
}

const NOT_PROVED: &str =
    "no level has a proved distance: make it again with --prove or, if that proved none, give a size";

impl std::fmt::Display for SimplifyError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Empty => write!(f, "the mesh has no faces: nothing to simplify"),
            Self::TooFewPoints(n) => write!(f, "{n} points are too few for a surface: give at least 3"),
            Self::BadTarget(target) => write!(
                f,
                "invalid size {target}: give a ratio above 0 and at most 1, or a count of at least 1, and levels from large to small"
            ),
            Self::BadError(x) => write!(f, "invalid distance {x}: must be at least 0"),
            Self::BadInput => write!(
                f,
                "attributes, importance or scores do not match the mesh: give one row per face, one positive number and one score per vertex"
            ),
            Self::BadProgression(why) => write!(f, "not a progression that this version reads: {why}: make it again"),
            Self::NotProved => f.write_str(NOT_PROVED),
            Self::BadImportance => write!(
                f,
                "invalid importance: must be one positive number per vertex, and every vertex must be on a face"
            ),
            Self::NoWeights => write!(
                f,
                "the paper's assembly needs weights, and this build has none: give weights or use the closed assembly"
            ),
            Self::NothingKept => write!(
                f,
                "the network kept no faces, as its weights do not fit this mesh: give other weights, or simplify with the closed assembly"
            ),
            Self::Overflow => write!(f, "coordinates near the limit of 32-bit floats: scale the mesh down first"),
            Self::Interrupted => write!(f, "interrupted"),
        }
    }
}

impl std::error::Error for SimplifyError {}
