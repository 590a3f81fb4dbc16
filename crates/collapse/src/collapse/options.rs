//! What a collapse is asked for, and how it can end.

use std::fmt;
use std::ops::ControlFlow;

use super::visit::Unit;

/// The size of the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CollapseSize {
    /// Number of faces; the result has one fewer where a merge removes two.
    Faces(usize),
    /// Number of vertices, copies of cut vertices included.
    Vertices(usize),
}

impl CollapseSize {
    pub(crate) fn to_unit_and_number(self) -> (Unit, usize) {
        match self {
            Self::Faces(n) => (Unit::Face, n),
            Self::Vertices(n) => (Unit::Vertex, n),
        }
    }
}

/// A size of several that are made in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CollapseTurn {
    /// The size, smaller or larger than the one before.
    pub size: CollapseSize,
    /// True if no other follows: what only others would need is freed.
    pub is_last: bool,
    /// True to keep the mesh after passes on the way to the first size, from which all others begin.
    pub keeps_way: bool,
}

/// Settings of [`collapse`](crate::collapse()).
#[derive(Clone)]
#[non_exhaustive]
pub struct CollapseOptions<'a> {
    /// Largest estimate of the distance between result and input, in the input's units; infinite: no bound.
    pub max_error: f32,
    /// True if vertices may move; otherwise a merged vertex is at one of the two.
    pub moves: bool,
    /// True if vertices on boundaries are locked, too.
    pub locks_boundaries: bool,
    /// Steps that move the vertices nearer to the input after the merges: 0 for speed, 2 for nearness; none without `moves`.
    pub n_fit_steps: usize,
    /// Vertices that keep their position, one flag per input vertex; others may be merged into them. Empty: none.
    pub locked: &'a [bool],
    /// Most threads of the current rayon pool to use; 0 is all of them. Results have the same bits on any number.
    pub n_threads: usize,
    /// True if vertices that are no disk are cut into copies; otherwise a mesh with such vertices is refused.
    pub cuts: bool,
    /// True if the record gets the merges, for derivatives.
    pub records_merges: bool,
    /// Called before each pass with the share of the merges that is done; a break ends the collapse as stopped.
    pub listener: Option<PassListener<'a>>,
    /// Called often while the collapse runs.
    pub heartbeat: Heartbeat<'a>,
}

/// Listener of the caller, called from any thread with the number of merges since the last call, mostly 0.
///
/// It may end the collapse by unwinding.
#[derive(Clone, Copy, Default)]
pub struct Heartbeat<'a>(Option<&'a (dyn Fn(usize) + Sync)>);

impl<'a> Heartbeat<'a> {
    /// No listener.
    pub const NONE: Self = Self(None);

    /// Returns the heartbeat that calls `listener`.
    pub fn new(listener: &'a (dyn Fn(usize) + Sync)) -> Self {
        Self(Some(listener))
    }

    pub(crate) fn beat(self, n_merges: usize) {
        if let Some(listener) = self.0 {
            listener(n_merges);
        }
    }
}

impl fmt::Debug for Heartbeat<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Heartbeat({})", self.0.is_some())
    }
}

/// Receives the progress of a collapse, from 0 to 1.
pub type PassListener<'a> = &'a (dyn Fn(f32) -> ControlFlow<()> + Sync);

impl Default for CollapseOptions<'_> {
    /// Returns the settings for speed: no fit, one thread, no bound, nothing locked.
    fn default() -> Self {
        Self {
            max_error: f32::INFINITY,
            moves: true,
            locks_boundaries: false,
            n_fit_steps: 0,
            locked: &[],
            n_threads: 1,
            cuts: true,
            records_merges: false,
            listener: None,
            heartbeat: Heartbeat::NONE,
        }
    }
}

/// Whether a collapse reached its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CollapseOutcome {
    /// The result has the size asked for.
    Reached,
    /// No merge was left that keeps the surface manifold, its faces unturned and the error; the result is larger.
    Stopped,
}

/// Why a mesh was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CollapseError {
    /// A face names a vertex that does not exist.
    IndexOutOfRange {
        /// The number of the face.
        face: usize,
    },
    /// A coordinate is NaN or infinite.
    NotFinite {
        /// The number of the vertex.
        vertex: usize,
    },
    /// The faces of a vertex are no disk.
    NotManifold,
    /// The mesh has more than 2^31 vertices, or corners than 2^32.
    TooLarge,
    /// An array has not the length that the others ask for.
    WrongLength {
        /// The name of the array.
        what: &'static str,
    },
}

impl fmt::Display for CollapseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::IndexOutOfRange { face } => write!(f, "face {face} names a vertex that does not exist"),
            Self::NotFinite { vertex } => write!(f, "vertex {vertex} has a coordinate that is not finite"),
            Self::NotManifold => write!(f, "the faces of a vertex are no disk"),
            Self::TooLarge => write!(f, "the mesh has more than 2^31 vertices or 2^32 corners"),
            Self::WrongLength { what } => write!(f, "{what}: the length does not fit the number of vertices"),
        }
    }
}

impl std::error::Error for CollapseError {}
