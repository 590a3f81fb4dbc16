//! Errors of the program.

use std::fmt;
use std::path::Path;
use std::process::ExitCode;

use neural_mesh::simplify::SimplifyError;

use crate::escapes::escape_controls;

/// Error that ends the program; its text says what failed, where, and what to do.
#[derive(Debug)]
pub enum Failure {
    /// Problem with the input or the disk: exit code 1.
    Failed(String),
    /// Wrong arguments: exit code 2.
    Usage(String),
    /// Option whose feature the build lacks: exit code 2.
    LacksFeature {
        /// Name of the option or command.
        option: String,
        /// Name of the feature.
        feature: String,
    },
    /// Result that is written but misses the target: exit code 3.
    Unmet(String),
    /// Errors that are already printed: exit code 1.
    Reported,
    /// Ctrl-C: exit code 130.
    Interrupted,
    /// Ctrl-C after results were saved, which the text names: exit code 130.
    Stopped(String),
}

impl Failure {
    /// Creates the error for a file.
    pub fn in_file(path: &Path, what: impl fmt::Display) -> Self {
        Self::Failed(format!("{}: {what}", display_path(path)))
    }

    /// Converts an error of the simplification.
    pub fn from_simplify(error: &SimplifyError, input: &Path) -> Self {
        match error {
            SimplifyError::Interrupted => Self::Interrupted,
            SimplifyError::BadTarget(_) | SimplifyError::BadError(_) => Self::Usage(error.to_string()),
            _ => Self::in_file(input, error),
        }
    }

    /// Returns the exit code of the program.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Failed(_) | Self::Reported => 1,
            Self::Usage(_) | Self::LacksFeature { .. } => 2,
            Self::Unmet(_) => 3,
            Self::Interrupted | Self::Stopped(_) => 130,
        })
    }
}

impl From<SimplifyError> for Failure {
    fn from(error: SimplifyError) -> Self {
        Self::from_simplify(&error, Path::new("the mesh"))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // Messages of libraries may hold line breaks, and file names anything; an error is one line.
            Self::Failed(text) | Self::Usage(text) | Self::Unmet(text) | Self::Stopped(text) => {
                f.write_str(&escape_controls(&text.replace(['\n', '\r'], " ")))
            }
            Self::LacksFeature { option, feature } => write!(
                f,
                "{option}: this build lacks the feature {feature}: install with `cargo install --path cli --features {feature}`"
            ),
            Self::Reported => write!(f, "some files failed: the lines above say why"),
            Self::Interrupted => write!(f, "interrupted: nothing was written"),
        }
    }
}

impl std::error::Error for Failure {}

/// Returns the name of a path for messages.
pub fn display_path(path: &Path) -> String {
    if path.as_os_str() == "-" { "standard input".into() } else { path.display().to_string() }
}
