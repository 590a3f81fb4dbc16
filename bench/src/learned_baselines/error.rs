//! Errors of learned methods.

use neural_mesh::mesh::InvalidMesh;

/// Reason why a learned method made no mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LearnedBaselineError {
    /// The result has no face.
    NothingLeft,
    /// The result is no valid mesh.
    Invalid(InvalidMesh),
}

impl std::fmt::Display for LearnedBaselineError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NothingLeft => write!(f, "the method left no face: ask for a larger mesh"),
            Self::Invalid(error) => write!(f, "the method's result is not a mesh: {error}"),
        }
    }
}

impl std::error::Error for LearnedBaselineError {}

impl From<InvalidMesh> for LearnedBaselineError {
    fn from(error: InvalidMesh) -> Self {
        Self::Invalid(error)
    }
}
