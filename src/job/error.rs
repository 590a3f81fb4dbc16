//! Errors of jobs.

use std::error::Error;
use std::fmt;

use crate::simplify::SimplifyError;

/// Error of a job, in one line without the name of the file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum JobError {
    /// Options that are out of range, contradict each other or do not suit the document.
    Options(String),
    /// Option that this build lacks.
    Feature {
        /// Name of the option.
        option: &'static str,
        /// Feature of the build that has it.
        feature: &'static str,
    },
    /// Document that cannot be read or simplified.
    Document(String),
    /// Result that cannot be written.
    Output(String),
    /// Run ended by the listener.
    Interrupted,
}

impl fmt::Display for JobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Options(text) | Self::Document(text) | Self::Output(text) => f.write_str(text),
            Self::Feature { option, feature } => write!(f, "{option}: this build lacks the feature {feature}"),
            Self::Interrupted => f.write_str("interrupted"),
        }
    }
}

impl Error for JobError {}

impl From<SimplifyError> for JobError {
    fn from(error: SimplifyError) -> Self {
        match error {
            SimplifyError::Interrupted => Self::Interrupted,
            SimplifyError::BadTarget(_) | SimplifyError::BadError(_) => Self::Options(error.to_string()),
            _ => Self::Document(error.to_string()),
        }
    }
}
