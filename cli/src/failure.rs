//! Why the program stops, in one line, and the exit code that says so.

use std::fmt;
use std::path::Path;
use std::process::ExitCode;

use neural_mesh::simplify::SimplifyError;

use crate::plain::plain;

/// A reason to stop; the text says what, where and what to do.
#[derive(Debug)]
pub enum Failure {
    /// The input or the disk: exit code 1.
    Failed(String),
    /// The arguments: exit code 2.
    Usage(String),
    /// What was written does not hold what was asked of it: exit code 3.
    Unmet(String),
    /// Some of several files, each of which had its line: exit code 1.
    Told,
    /// Ctrl-C: exit code 130.
    Interrupted,
    /// Ctrl-C where something was kept; the text says what: exit code 130.
    Stopped(String),
}

impl Failure {
    /// A failure that concerns a file.
    pub fn of(path: &Path, what: impl fmt::Display) -> Self {
        Self::Failed(format!("{}: {what}", name(path)))
    }

    /// The library's refusal to simplify a file as the program's.
    pub fn of_simplify(error: &SimplifyError, input: &Path) -> Self {
        match error {
            SimplifyError::Interrupted => Self::Interrupted,
            SimplifyError::BadTarget(_) | SimplifyError::BadError(_) | SimplifyError::NotWithSymmetry(_) => {
                Self::Usage(error.to_string())
            }
            _ => Self::of(input, error),
        }
    }

    /// The exit code of the program.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Failed(_) | Self::Told => 1,
            Self::Usage(_) => 2,
            Self::Unmet(_) => 3,
            Self::Interrupted | Self::Stopped(_) => 130,
        })
    }
}

impl From<SimplifyError> for Failure {
    fn from(error: SimplifyError) -> Self {
        Self::of_simplify(&error, Path::new("the mesh"))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // A message from elsewhere may hold line breaks, a name of a file anything; a failure is one line.
            Self::Failed(text) | Self::Usage(text) | Self::Unmet(text) | Self::Stopped(text) => {
                f.write_str(&plain(&text.replace(['\n', '\r'], " ")))
            }
            Self::Told => write!(f, "some files failed: the lines above say why"),
            Self::Interrupted => write!(f, "interrupted: nothing was written"),
        }
    }
}

/// What a path is called in messages.
pub fn name(path: &Path) -> String {
    if path.as_os_str() == "-" { "standard input".into() } else { path.display().to_string() }
}
