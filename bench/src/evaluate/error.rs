//! Errors of an evaluation, one line each. A failing method is no error but a row.

use std::path::{Path, PathBuf};

/// An error that prevents or ends an evaluation.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EvaluateError {
    /// An unknown setting or one out of range, named in the text.
    Settings(String),
    /// A problem with a file or folder.
    File {
        /// Path of the file or folder.
        path: PathBuf,
        /// The problem and its remedy.
        what: String,
    },
    /// A tool that failed on a small mesh, with its failure.
    Tool(String),
    /// Rows with other settings, with the difference.
    Differs(String),
}

impl EvaluateError {
    /// Makes an error about a file.
    pub(super) fn file(path: &Path, what: impl std::fmt::Display) -> Self {
        Self::File { path: path.into(), what: what.to_string() }
    }
}

impl std::fmt::Display for EvaluateError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Settings(what) | Self::Tool(what) => write!(f, "{what}"),
            Self::File { path, what } => write!(f, "{}: {what}", path.display()),
            Self::Differs(what) => {
                write!(f, "the rows do not match: {what}: use the same again, or start over")
            }
        }
    }
}

impl std::error::Error for EvaluateError {}
