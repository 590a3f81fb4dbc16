//! Errors of requests.

use std::fmt::Display;

#[cfg(feature = "documents")]
use neural_mesh::simplify::SimplifyError;
use neural_mesh_collapse::CollapseError;

/// One-line error message for the caller.
#[derive(Debug)]
pub struct Refusal {
    /// Message: the problem, its place, and advice.
    pub what: String,
    /// True if the caller ended the run.
    pub is_interrupted: bool,
}

impl Refusal {
    /// Creates an error from its message.
    pub fn new(what: impl Display) -> Self {
        Self { what: what.to_string(), is_interrupted: false }
    }
}

impl From<CollapseError> for Refusal {
    fn from(error: CollapseError) -> Self {
        Self::new(error)
    }
}

#[cfg(feature = "documents")]
impl From<SimplifyError> for Refusal {
    fn from(error: SimplifyError) -> Self {
        Self { is_interrupted: matches!(error, SimplifyError::Interrupted), ..Self::new(error) }
    }
}

impl From<serde_json::Error> for Refusal {
    fn from(error: serde_json::Error) -> Self {
        Self::new(error)
    }
}
