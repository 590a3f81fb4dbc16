//! What a caller asks of the simplifier and what it is told: plain data, no algorithm.

use std::ops::ControlFlow;

use crate::mesh::{Attributes, Frame, TriMesh};

/// How large the result should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// Share of the vertices that stay, the paper's N_s / N_org; above 0, at most 1.
    Ratio(f64),
    /// Number of vertices.
    Vertices(usize),
    /// Number of faces.
    Faces(usize),
}

impl Target {
    /// About the share of a mesh that stays: of the vertices where these are asked for, else of the faces.
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

/// How sampled vertices become a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Assembly {
    /// Closed where the input was closed: collapse, flips, fit.
    #[default]
    Closed,
    /// The paper's (Sec. 4): faces with p > 0.5, the best two per edge, vertices at input positions.
    Paper,
}

/// Settings of one simplification; `Options::new(target)` has the defaults.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// The size asked for.
    pub target: Target,
    /// The assembly.
    pub assembly: Assembly,
    /// Where the scores come from (closed assembly only; the paper's always asks its network).
    pub scores: ScoreSource,
    /// What the result is to be near in (closed assembly only).
    pub optimize: Optimize,
    /// How long it may take (closed assembly only).
    pub effort: Effort,
    /// Seed of the sampling (paper assembly only).
    pub seed: u64,
    /// Whether components may go that cost more vertices than they show (closed assembly only). All stay with `lock_boundaries`,
    /// `subset` and `symmetric`, and at the mesh's own size.
    pub prune: bool,
    /// No component goes for its price that reaches farther than this from those that stay, in the unit of the mesh. Where it is finite,
    /// components may lose their shape up to it.
    pub prune_within: f64,
    /// Components whose bounding box has a diagonal below this, in the unit of the mesh, are dropped; the largest by area
    /// stays (closed assembly only). 0 drops none.
    pub prune_below: f64,
    /// What becomes of what no ray from outside reaches (closed assembly only).
    pub hidden: Hidden,
    /// Whether the vertices and edges of the boundaries stay as they are (closed assembly only), bit for bit.
    pub lock_boundaries: bool,
    /// Whether the vertices of the result are vertices of the input (closed assembly; the paper's always are).
    pub subset: bool,
    /// Whether the holes that the network leaves are closed (paper assembly only; the closed one leaves none).
    pub close: bool,
    /// How far a seam of texture coordinates may leave its place at a low price, in shares of the texture's side (closed assembly
    /// only). At 0 seams are held like creases: curves that lose no more than vertices.
    pub seam_error: f64,
    /// What the result is for (closed assembly only).
    pub purpose: Purpose,
    /// Edges between faces whose normals are more than so many degrees apart stay edges (closed assembly only).
    pub crease_angle: Option<f32>,
    /// Whether the result says where it comes from, vertex by vertex and corner by corner (closed assembly only).
    pub map: bool,
    /// Whether the result is its own mirror image, as the mesh has to be (closed assembly only).
    pub symmetric: Option<Symmetry>,
    /// How the coordinates will be rounded when written: no two vertices of the result share a rounded position.
    pub frame: Frame,
}

/// What a result is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Purpose {
    /// To be near as it stands.
    #[default]
    Shape,
    /// To be near in the poses, too, that morph targets of the input take the mesh to, each alone; without targets, in poses that
    /// nobody knows, as if every place might bend alike.
    Poses,
    /// To have the eigenfunctions of the Laplacian of the original (LE): faces of like areas, whatever the surface does.
    Spectrum,
}

/// What becomes of surfaces that no ray from outside reaches ([`hidden_faces`](super::hidden_faces)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Hidden {
    /// They count like others.
    #[default]
    Keep,
    /// They count a thousandth: they keep about a tenth of the vertices that they would have.
    Cheap,
    /// Components that are hidden as a whole are dropped, and the distance is that from the rest; what else is hidden counts like
    /// others.
    Drop,
}

/// Sixteen texels of a texture of 1024 texels a side. Five textured models, four ratios: at eight the mean distance is 1 % farther,
/// without an end it is the same.
pub const SEAM_ERROR: f64 = 16.0 / 1024.0;

impl Options {
    /// The defaults for a target: closed assembly, scores by how much the surface bends, seed 0, coordinates written as `f32`.
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
            seam_error: SEAM_ERROR,
            purpose: Purpose::default(),
            crease_angle: None,
            map: false,
            symmetric: None,
            frame: Frame::default(),
        }
    }
}

/// An axis of the coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

impl Axis {
    /// All of them, in order.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Its place among the coordinates: 0, 1 or 2.
    pub fn index(self) -> usize {
        self as usize
    }
}

impl std::fmt::Display for Axis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(["x", "y", "z"][self.index()])
    }
}

/// The plane about which a mesh is its own mirror image: the points of one coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorPlane {
    /// The axis across which it lies.
    pub axis: Axis,
    /// The coordinate of its points, in the file: the local one is that less the frame's origin.
    pub at: f64,
}

impl std::fmt::Display for MirrorPlane {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} = {}", self.axis, self.at)
    }
}

/// Which plane a mesh is mirrored about.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Symmetry {
    /// The one that fits best of those across the three axes, through 0 and through the middle of the bounding box.
    Found,
    /// The better one of those across this axis.
    Across(Axis),
    /// This one.
    Plane(MirrorPlane),
}

/// What the closed assembly does beside the collapse: switches for measuring what each is worth.
/// [`simplify`](super::simplify) does all of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Parts {
    /// Flips edges whose other diagonal lies nearer to the original.
    pub flips: bool,
    /// Moves the vertices of the result toward the original.
    pub fit: bool,
}

impl Default for Parts {
    /// All of it.
    fn default() -> Self {
        Self { flips: true, fit: true }
    }
}

/// Where the scores come from, which say where the result is to have more vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ScoreSource {
    /// From a formula: more vertices where the surface bends. Where weights are given, from their network.
    #[default]
    Bending,
    /// From the network's Point Sampler.
    Network,
    /// From the geometry alone: every vertex counts by its area. No weights are used.
    Geometry,
}

/// The figure in which a result is to be near, and what that costs the others (`docs/measured/benchmark.md`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Optimize {
    /// Good in all of them.
    #[default]
    Balanced,
    /// The mean distance. Every vertex counts by its area, no scores are asked for; takes longer.
    Mean,
    /// The largest distance. More vertices go where the surface bends; the mean distance is farther.
    Max,
    /// The normals, and so the shading. The same trade.
    Normals,
}

/// How long a result may take: three points of one curve, time against distance (`docs/measured/benchmark.md`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Effort {
    /// The collapse alone: vertices lie where their merges put them.
    Fast,
    /// What pays.
    #[default]
    Standard,
    /// All that brings the result nearer: more points of the original, and more steps toward them.
    Best,
}

/// Whether the size asked for was reached, or what stopped it short.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// At most the size asked for, and at most one vertex or face below it (a face where parity forbids).
    Reached,
    /// The result is larger than asked, and the text says which constraint holds it; or, of a search, it does not hold what was asked.
    Stopped(String),
}

/// What was done on the way.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// Whether the target was reached.
    pub outcome: Outcome,
    /// Where the scores came from.
    pub scores: ScoreSource,
    /// Components that stand in the result in their smallest closed form.
    pub components_at_minimum: usize,
    /// Whether a smaller result would take the shape of a component.
    pub components_keep_shape: bool,
    /// Components dropped.
    pub components_pruned: usize,
    /// How many of these were hidden.
    pub components_hidden: usize,
    /// The components dropped, each by its first face.
    pub dropped: Vec<DroppedComponent>,
    /// Edges of the input that had to stay edges: seams and creases.
    pub kept_edges: usize,
    /// Vertices of the input that had to stay where they are.
    pub locked_vertices: usize,
    /// Vertices that were split because more than one sheet met there, and edges that were cut likewise.
    pub split_vertices: usize,
    /// Edges that gave way to the other diagonal of their faces.
    pub flipped_edges: usize,
    /// Output vertices moved apart because their written positions would have been the same.
    pub separated_vertices: usize,
    /// The plane that the result is mirrored about, if it was to be. What was done is then counted on one of the halves.
    pub mirror: Option<MirrorPlane>,
}

/// A component of the input that the result lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct DroppedComponent {
    /// Its first face in the input.
    pub face: u32,
    /// Faces that it had.
    pub n_faces: usize,
}

/// The result: a mesh and what was done.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Simplified {
    /// The lighter mesh.
    pub mesh: TriMesh,
    /// What its corners and faces carry; nothing where the input carries nothing, and with the paper's assembly.
    pub attributes: Attributes,
    /// For each output vertex the input vertex whose position it has, where every vertex has one
    /// (paper assembly, subset, or nothing to do).
    pub source_vertices: Option<Vec<u32>>,
    /// Where it comes from, if the options asked for that.
    pub map: Option<Map>,
    /// What was done.
    pub report: Report,
}

/// How a result hangs together with its input, for data that the caller carries over.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Map {
    /// The output vertex that each input vertex went into, n_input; `u32::MAX` where it was dropped or is on no face.
    pub output_vertices: Vec<u32>,
    /// The input vertex nearest to each output vertex, of those that went into it, n_output.
    pub input_vertices: Vec<u32>,
    /// For each corner of the output's faces the input face that it stands on, n_faces x 3; on the corner's side of seams.
    pub corner_faces: Vec<[u32; 3]>,
    /// The weights of that face's corners there, n_faces x 3 x 3; each three are at least 0, their sum 1.
    pub corner_weights: Vec<[[f32; 3]; 3]>,
}

/// A stage begins, or moves on.
///
/// Events come from whichever thread is at work, one at a time. In the closed assembly they come every few milliseconds, in the
/// paper's at the beginning of each stage.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Event {
    /// Name of the stage, as in the report.
    pub stage: &'static str,
    /// Share of the stage that is done, in 0..=1: 0 at its beginning, and never less than before.
    pub done: f32,
    /// Share of the run that is done, in 0..=1, by the time that stages take on a large mesh; never less than before.
    pub total: f32,
}

/// Who hears of a run's events, and stops it by `ControlFlow::Break`.
///
/// A run in the closed assembly stops within about a tenth of a second of being asked, one in the paper's when its stage ends. A
/// build with `panic = "abort"` stops when a stage ends, whichever the assembly.
pub type Listener<'a> = dyn FnMut(Event) -> ControlFlow<()> + Send + 'a;

/// Why there is no result.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SimplifyError {
    /// The mesh has no face.
    Empty,
    /// A surface needs three points; so many there are, or are asked for.
    TooFewPoints(usize),
    /// The target is not a size: zero, not a number, a ratio above 1.
    BadTarget(Target),
    /// The largest distance asked for is negative or not a number.
    BadError(f64),
    /// The attributes have not one row for each face, or there is not one importance for each vertex.
    BadInput,
    /// The mesh is not its own mirror image.
    NotSymmetric {
        /// The plane about which it was looked for.
        plane: MirrorPlane,
        /// Vertices without a vertex where their image lies.
        vertices: usize,
        /// Faces without such faces, counted where all vertices have images.
        faces: usize,
    },
    /// So many faces lie in the plane of the symmetry: they have no side.
    InMirrorPlane(usize),
    /// What symmetry is not there for.
    NotWithSymmetry(&'static str),
    /// Not one positive factor for every vertex, or there are vertices that no face uses.
    BadImportance,
    /// The paper's assembly needs weights, and neither the caller nor this build has any.
    NoWeights,
    /// The network's probabilities leave no face.
    NothingKept,
    /// Coordinates of the result are too large for `f32`.
    Overflow,
    /// The progress callback asked to stop.
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
