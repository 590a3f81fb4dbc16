//! What a collapse is asked for, and how it can end.

use std::fmt;

/// The size of the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CollapseSize {
    /// Number of faces; the result has one fewer where a merge removes two.
    Faces(usize),
    /// Number of vertices, copies of cut vertices included.
    Vertices(usize),
}

/// Settings of [`collapse`](crate::collapse()).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct CollapseOptions<'a> {
    /// The size asked for.
    pub size: CollapseSize,
    /// Steps that move the vertices nearer to the input after the merges: 0 for speed, 2 for nearness.
    pub n_fit_steps: usize,
    /// Vertices that keep their position, one flag per input vertex; others may be merged into them. Empty: none.
    pub locked: &'a [bool],
    /// Most threads of the current rayon pool to use; 0 is all of them. Results have the same bits on any number.
    pub n_threads: usize,
}

impl CollapseOptions<'_> {
    /// Returns the settings for speed: no fit, one thread, nothing locked.
    pub fn new(size: CollapseSize) -> CollapseOptions<'static> {
        CollapseOptions { size, n_fit_steps: 0, locked: &[], n_threads: 1 }
    }
}

/// Whether a collapse reached its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CollapseOutcome {
    /// The result has the size asked for.
    Reached,
    /// No merge was left that keeps the surface manifold and its faces unturned; the result is larger.
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
    /// The mesh has more than 2^31 vertices, or corners than 2^32.
    TooLarge,
    /// There is not one lock per vertex.
    WrongNumberOfLocks,
}

impl fmt::Display for CollapseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::IndexOutOfRange { face } => write!(f, "face {face} names a vertex that does not exist"),
            Self::NotFinite { vertex } => write!(f, "vertex {vertex} has a coordinate that is not finite"),
            Self::TooLarge => write!(f, "the mesh has more than 2^31 vertices or 2^32 corners"),
            Self::WrongNumberOfLocks => write!(f, "the number of locks is not the number of vertices"),
        }
    }
}

impl std::error::Error for CollapseError {}
