//! Reasons why index buffers are not simplified.

use std::fmt;

use crate::simplify::SimplifyError;

/// Reason for a failed run.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum IndexError {
    /// Wrong buffer, named by the text.
    Buffers(String),
    /// Error of the simplifier.
    Simplify(SimplifyError),
}

impl fmt::Display for IndexError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Buffers(reason) => f.write_str(reason),
            Self::Simplify(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for IndexError {}

impl From<SimplifyError> for IndexError {
    fn from(error: SimplifyError) -> Self {
        Self::Simplify(error)
    }
}
