//! Why a request has no answer.

use std::fmt::Display;

use neural_mesh::simplify::SimplifyError;

/// One line for whoever asked.
#[derive(Debug)]
pub struct Refusal {
    /// The message: what is wrong, where, and what to do.
    pub what: String,
    /// Whether the caller ended the run.
    pub is_interrupted: bool,
}

impl Refusal {
    /// A refusal of this line.
    pub fn new(what: impl Display) -> Self {
        Self { what: what.to_string(), is_interrupted: false }
    }
}

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
