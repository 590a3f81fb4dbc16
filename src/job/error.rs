//! Why a job ends without a result.

use std::error::Error;
use std::fmt;

use crate::simplify::SimplifyError;

/// A reason to stop, in one line that says what and what to do; whoever named the input or the output says where.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum JobError {
    /// Options that are out of range, contradict each other or do not suit the document.
    Options(String),
    /// The document cannot be read or simplified so.
    Document(String),
    /// A result cannot be written.
    Output(String),
    /// Whoever watches ended it.
    Interrupted,
}

impl fmt::Display for JobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Options(text) | Self::Document(text) | Self::Output(text) => f.write_str(text),
            Self::Interrupted => f.write_str("interrupted"),
        }
    }
}

impl Error for JobError {}

impl From<SimplifyError> for JobError {
    fn from(error: SimplifyError) -> Self {
        match error {
            SimplifyError::Interrupted => Self::Interrupted,
            SimplifyError::BadTarget(_) | SimplifyError::BadError(_) | SimplifyError::NotWithSymmetry(_) => {
                Self::Options(error.to_string())
            }
            _ => Self::Document(error.to_string()),
        }
    }
}
