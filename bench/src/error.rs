//! Errors of an evaluation and its rows.

use std::path::{Path, PathBuf};

/// An error that ends an evaluation; a failing method is a row instead.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EvaluateError {
    /// An unknown setting or one out of range.
    Settings(String),
    /// A problem with a file or folder.
    File {
        /// Path.
        path: PathBuf,
        /// Problem and remedy.
        what: String,
    },
    /// Rows measured with other settings.
    Differs(String),
}

impl EvaluateError {
    pub(crate) fn file(path: &Path, what: impl std::fmt::Display) -> Self {
        Self::File { path: path.into(), what: what.to_string() }
    }
}

impl std::fmt::Display for EvaluateError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Settings(what) => write!(f, "{what}"),
            Self::File { path, what } => write!(f, "{}: {what}", path.display()),
            Self::Differs(what) => {
                write!(f, "the rows do not match: {what}: undo this change, or evaluate into another folder")
            }
        }
    }
}

impl std::error::Error for EvaluateError {}
