//! Options, results and errors of the simplifier: plain data without an algorithm.

use std::ops::ControlFlow;

use crate::mesh::{Attributes, Frame, TriMesh};

/// Size of the result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// Share of the vertices that remain, the paper's N_s / N_org; above 0, at most 1.
    Ratio(f64),
    /// Number of vertices.
    Vertices(usize),
    /// Number of faces.
    Faces(usize),
}

impl Target {
    /// Returns the approximate share of the mesh that remains: of its faces for [`Target::Faces`], else of its
    /// vertices.
    ///
    /// ```
    /// use neural_mesh::{mesh::shapes, simplify::Target};
    /// let sphere = shapes::icosphere(0);
    /// assert_eq!([Target::Ratio(0.3), Target::Vertices(6), Target::Faces(5)].map(|it| it.share_of(&sphere)), [0.3, 0.5, 0.25]);
    /// ```
    pub fn share_of(self, mesh: &TriMesh) -> f64 {
        let of = |n: usize, n_all: usize| n as f64 / n_all.max(1) as f64;
        match self {
            Self::Ratio(ratio) => ratio,
            Self::Vertices(n) => of(n, mesh.positions().len()),
            Self::Faces(n) => of(n, mesh.faces().len()),
        }
    }
}

/// Method that builds the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Assembly {
    /// Closed where the input is closed: collapse, flips, fit.
    #[default]
    Closed,
    /// The paper's (Sec. 4): faces with p > 0.5, at most two per edge, vertices at input positions.
    Paper,
}

/// Settings of one simplification; [`Options::new`] sets the defaults.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// Size of the result.
    pub target: Target,
    /// Method that builds the surface.
    pub assembly: Assembly,
    /// Source of the scores (closed assembly only; the paper's always uses its network).
    pub scores: ScoreSource,
    /// Error measure to optimise (closed assembly only).
    pub optimize: Optimize,
    /// Time budget (closed assembly only).
    pub effort: Effort,
    /// Seed of the sampling (paper's assembly only).
    pub seed: u64,
    /// Drops components whose vertices are better spent elsewhere (closed assembly only). Has no effect with
    /// `lock_boundaries`, `subset` or `symmetric`, nor at the size of the input.
    pub prune: bool,
    /// Largest distance to the rest at which `prune` may drop a component, in mesh units. Where finite, components may
    /// lose their shape up to it.
    pub prune_within: f64,
    /// Drops components whose bounding box has a smaller diagonal, in mesh units; the largest by area stays (closed
    /// assembly only). 0 drops none.
    pub prune_below: f64,
    /// Treatment of surfaces that are invisible from outside (closed assembly only).
    pub hidden: Hidden,
    /// Keeps boundary vertices and edges bit for bit (closed assembly only).
    pub lock_boundaries: bool,
    /// Restricts output vertices to positions of input vertices (closed assembly; always so in the paper's).
    pub subset: bool,
    /// Closes the holes that the network leaves (paper's assembly only).
    pub close: bool,
    /// Samples once more by the errors of the first samples' regions, and moves vertices to the minimum of their region's
    /// quadric (paper's assembly only).
    pub place: bool,
    /// Distance that texture seams may move at a low price, as a share of the texture's side (closed assembly only). At
    /// 0 seams are held like creases.
    pub seam_error: f64,
    /// Use of the result (closed assembly only).
    pub purpose: Purpose,
    /// Least angle between face normals, in degrees, at which an edge is kept as a crease (closed assembly only).
    pub crease_angle: Option<f32>,
    /// Returns a [`Map`] between input and output (closed assembly only).
    pub map: bool,
    /// Makes the result its own mirror image; the input must be one (closed assembly only).
    pub symmetric: Option<Symmetry>,
    /// Rounding of the written coordinates: no two vertices of the result share a rounded position.
    pub frame: Frame,
}

/// Use of a result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Purpose {
    /// The shape in its present pose.
    #[default]
    Shape,
    /// All poses given by the input's morph targets, each alone; without targets, unknown poses in which every place
    /// may bend alike.
    Poses,
    /// The eigenfunctions of the Laplacian (metric LE): faces of similar areas.
    Spectrum,
}

/// Treatment of surfaces that are invisible from outside ([`hidden_faces`](super::hidden_faces)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Hidden {
    /// Treats hidden surfaces like visible ones.
    #[default]
    Keep,
    /// Weights hidden surfaces by a thousandth: they keep about a tenth of their vertices.
    Cheap,
    /// Drops components that are hidden as a whole. Distances are then measured to what remains.
    Drop,
}

/// Default seam slack: 16 texels of a texture with 1024 texels a side. On five textured models at four ratios 8 texels
/// give a 1 % larger mean distance, unlimited slack an equal one.
pub const SEAM_ERROR: f64 = 16.0 / 1024.0;

impl Options {
    /// Returns the defaults: closed assembly, scores by bending, seed 0, coordinates written as `f32`.
    pub fn new(target: Target) -> Self {
        Self {
            target,
            assembly: Assembly::default(),
            scores: ScoreSource::default(),
            optimize: Optimize::default(),
            effort: Effort::default(),
            seed: 0,
            prune: true,
            prune_within: f64::INFINITY,
            prune_below: 0.0,
            hidden: Hidden::default(),
            lock_boundaries: false,
            subset: false,
            close: false,
            place: false,
            seam_error: SEAM_ERROR,
            purpose: Purpose::default(),
            crease_angle: None,
            map: false,
            symmetric: None,
            frame: Frame::default(),
        }
    }
}

/// Coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// First axis.
    X,
    /// Second axis.
    Y,
    /// Third axis.
    Z,
}

impl Axis {
    /// All axes in order.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Returns the index of the coordinate: 0, 1 or 2.
    pub fn index(self) -> usize {
        self as usize
    }
}

impl std::fmt::Display for Axis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(["x", "y", "z"][self.index()])
    }
}

/// Axis-aligned plane about which a mesh is its own mirror image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorPlane {
    /// Axis perpendicular to the plane.
    pub axis: Axis,
    /// Coordinate of the plane in the file; the local coordinate is this minus the frame's origin.
    pub at: f64,
}

impl std::fmt::Display for MirrorPlane {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} = {}", self.axis, self.at)
    }
}

/// Choice of the mirror plane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Symmetry {
    /// Best fit among the planes across the three axes, through 0 and through the centre of the bounding box.
    Best,
    /// Better one of the two planes across this axis.
    Across(Axis),
    /// Given plane.
    Plane(MirrorPlane),
}

/// Switches of the steps after the collapse, for measuring their effect. [`simplify`](super::simplify) runs all of
/// them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Refinements {
    /// Flips edges whose other diagonal is nearer to the original.
    pub flips: bool,
    /// Moves vertices toward the original.
    pub fit: bool,
}

impl Default for Refinements {
    /// Switches on all steps.
    fn default() -> Self {
        Self { flips: true, fit: true }
    }
}

/// Source of the scores, which say where the result keeps more vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ScoreSource {
    /// A formula that favours places where the surface bends; the network where weights are given.
    #[default]
    Bending,
    /// The network's Point Sampler.
    Network,
    /// None: every vertex counts by its area. No weights are used.
    Geometry,
}

/// Error measure to optimise and its trade-offs (`docs/measured/benchmark.md`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Optimize {
    /// A good value of every measure.
    #[default]
    Balanced,
    /// Mean distance. Vertices count by their area, without scores; takes longer.
    Mean,
    /// Largest distance. Places that bend keep more vertices; the mean distance grows.
    Max,
    /// Normals, and so the shading. Trades as `Max` does.
    Normals,
}

/// Time budget: three points of one curve, time against distance (`docs/measured/benchmark.md`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Effort {
    /// Collapse alone: vertices keep the positions of their merges.
    Fast,
    /// Default trade-off.
    #[default]
    Standard,
    /// More sample points of the original, and more steps toward them.
    Best,
}

/// Result of the size target.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Size reached, at most one vertex or face below the target (a face where parity forbids the target).
    Reached,
    /// Result larger than the target; the text names the constraint. For a search: the limit is not met.
    Stopped(String),
}

/// Statistics of one run.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// Result of the size target.
    pub outcome: Outcome,
    /// Source of the scores.
    pub scores: ScoreSource,
    /// Components of the result in their smallest form: tetrahedra or single triangles.
    pub components_at_minimum: usize,
    /// Set where a smaller result would deform a component too far.
    pub components_keep_shape: bool,
    /// Number of dropped components.
    pub components_pruned: usize,
    /// Number of dropped components that were hidden.
    pub components_hidden: usize,
    /// Dropped components, ascending by their first face.
    pub dropped: Vec<DroppedComponent>,
    /// Input edges that had to remain edges: seams and creases.
    pub kept_edges: usize,
    /// Input vertices that had to stay in place.
    pub locked_vertices: usize,
    /// Number of vertices and edges split because more than one sheet meets there.
    pub split_vertices: usize,
    /// Number of flipped edges.
    pub flipped_edges: usize,
    /// Output vertices moved because their written positions coincided.
    pub separated_vertices: usize,
    /// Mirror plane of a symmetric result. All counts are then those of one half.
    pub mirror: Option<MirrorPlane>,
}

/// Input component that the result lacks.
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
    /// Attributes of corners and faces; empty where the input has none, and with the paper's assembly.
    pub attributes: Attributes,
    /// Input vertex at the position of each output vertex, where all output vertices have one (paper's assembly,
    /// subset, or unchanged mesh).
    pub source_vertices: Option<Vec<u32>>,
    /// Correspondence with the input, where [`Options::map`] is set.
    pub map: Option<Map>,
    /// Statistics of the run.
    pub report: Report,
}

/// Correspondence between a result and its input, for transferring user data.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Map {
    /// Output vertex into which each input vertex was merged, n_input; `u32::MAX` where dropped or on no face.
    pub output_vertices: Vec<u32>,
    /// Nearest of the input vertices merged into each output vertex, n_output.
    pub input_vertices: Vec<u32>,
    /// Input face beneath each output corner, n_faces x 3; on the corner's side of seams.
    pub corner_faces: Vec<[u32; 3]>,
    /// Barycentric weights on that face, n_faces x 3 x 3; each triple is at least 0 and sums to 1.
    pub corner_weights: Vec<[[f32; 3]; 3]>,
}

/// Progress of a run: a stage begins or advances.
///
/// Events come one at a time from whichever thread is working: every few milliseconds in the closed assembly, at the
/// beginning of each stage in the paper's.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Event {
    /// Name of the stage.
    pub stage: &'static str,
    /// Completed share of the stage, in 0..=1; starts at 0 and never falls.
    pub done: f32,
    /// Completed share of the run, in 0..=1, by typical times on a large mesh; never falls.
    pub total: f32,
}

/// Progress callback; `ControlFlow::Break` stops the run.
///
/// The closed assembly stops within about a tenth of a second, the paper's at the end of its stage. Builds with `panic
/// = "abort"` always stop at the end of a stage.
pub type Listener<'a> = dyn FnMut(Event) -> ControlFlow<()> + Send + 'a;

/// Reason for a missing result.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SimplifyError {
    /// The mesh has no face.
    Empty,
    /// Fewer than three points, given or requested.
    TooFewPoints(usize),
    /// The target is not a size: zero, not a number, or a ratio above 1.
    BadTarget(Target),
    /// The largest allowed distance is negative or not a number.
    BadError(f64),
    /// Attributes do not have one row per face, or importance not one positive factor per vertex.
    BadInput,
    /// The mesh is not its own mirror image.
    NotSymmetric {
        /// Best plane tried.
        plane: MirrorPlane,
        /// Number of vertices without an image.
        vertices: usize,
        /// Number of faces without an image, counted where all vertices have one.
        faces: usize,
    },
    /// This many faces lie in the mirror plane and belong to neither side.
    InMirrorPlane(usize),
    /// Option that cannot be combined with symmetry.
    NotWithSymmetry(&'static str),
    /// Importance is not one positive factor per vertex, or some vertex is on no face.
    BadImportance,
    /// The paper's assembly has no weights: neither the caller's nor shipped ones.
    NoWeights,
    /// No face has a probability above one half.
    NothingKept,
    /// Result coordinates exceed `f32`.
    Overflow,
    /// The progress callback stopped the run.
    Interrupted,
}

impl std::fmt::Display for SimplifyError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Empty => write!(f, "the mesh has no faces: nothing to simplify"),
            Self::TooFewPoints(n) => write!(f, "{n} points are too few for a surface: give at least 3"),
            Self::BadTarget(target) => {
                write!(f, "invalid size {target:?}: must be a ratio above 0 and at most 1, or a count of at least 1")
            }
            Self::BadError(x) => write!(f, "invalid distance {x}: must be at least 0"),
            Self::BadInput => write!(
                f,
                "attributes or importance do not match the mesh: give one row per face and one positive number per vertex"
            ),
            Self::NotSymmetric { plane, vertices: 0, faces } => write!(
                f,
                "not symmetric about {plane}: {faces} faces have no mirror image: choose another plane or turn symmetry off"
            ),
            Self::NotSymmetric { plane, vertices, .. } => write!(
                f,
                "not symmetric about {plane}: {vertices} vertices have no mirror image: choose another plane or turn symmetry off"
            ),
            Self::InMirrorPlane(n) => {
                write!(f, "{n} faces lie in the mirror plane: remove them or turn symmetry off")
            }
            Self::NotWithSymmetry(what) => write!(f, "{what} and symmetry cannot be combined: leave one out"),
            Self::BadImportance => {
                write!(
                    f,
                    "invalid importance: must be one positive number per vertex, and every vertex must be on a face"
                )
            }
            Self::NoWeights => write!(
                f,
                "the paper's assembly needs weights, and this build has none: give weights or use the closed one"
            ),
            Self::NothingKept => write!(f, "the network kept no faces: these weights do not fit this mesh"),
            Self::Overflow => write!(f, "coordinates near the limit of 32-bit floats: scale the mesh down first"),
            Self::Interrupted => write!(f, "interrupted"),
        }
    }
}

impl std::error::Error for SimplifyError {}
