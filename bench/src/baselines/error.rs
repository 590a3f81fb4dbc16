//! Errors of baseline methods.

use neural_mesh::mesh::InvalidMesh;

/// Reason why a method made no mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BaselineError {
    /// The input has no faces.
    Empty,
    /// The result has no face.
    NothingLeft,
    /// The result is no valid mesh.
    Invalid(InvalidMesh),
}

impl std::fmt::Display for BaselineError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Empty => write!(f, "the mesh has no faces: there is nothing to simplify"),
            Self::NothingLeft => write!(f, "the method left no face: ask for a larger mesh"),
            Self::Invalid(error) => write!(f, "the method's result is not a mesh: {error}"),
        }
    }
}

impl std::error::Error for BaselineError {}

impl From<InvalidMesh> for BaselineError {
    fn from(error: InvalidMesh) -> Self {
        Self::Invalid(error)
    }
}
