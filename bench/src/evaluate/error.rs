//! Why an evaluation does not begin or go on, in one line each. A method that fails is no error: it is a row.

use std::path::{Path, PathBuf};

/// Why an evaluation does not begin or go on.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EvaluateError {
    /// A setting is unknown or out of range; the text names it.
    Settings(String),
    /// A file or folder; the text says what is wrong with it and what to do.
    File {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong and what to do.
        what: String,
    },
    /// A tool that does not do what it is asked for on a small mesh; the text says what came of it.
    Tool(String),
    /// Rows that were measured with something else; the text names the difference.
    Differs(String),
}

impl EvaluateError {
    /// An error about a file.
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
