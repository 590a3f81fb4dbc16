//! Errors of a training, one line each.

use std::path::{Path, PathBuf};

/// Reason why a training cannot begin or continue.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TrainError {
    /// A setting is unknown or out of range; the text names it.
    Settings(String),
    /// A file or folder is unusable.
    File {
        /// The file or folder.
        path: PathBuf,
        /// The fault and its remedy.
        what: String,
    },
    /// A checkpoint was made with other inputs; the text names the difference.
    Differs(String),
    /// A loss or gradient is not finite, or a loss explodes.
    Diverged {
        /// Step over all epochs, from 1.
        step: u64,
        /// File of the mesh.
        mesh: String,
        /// The term or tensor, and its fault.
        what: String,
    },
    /// The step function used no mesh of an epoch, or changed its terms.
    Step(String),
}

impl TrainError {
    pub(super) fn file(path: &Path, what: impl std::fmt::Display) -> Self {
        Self::File { path: path.into(), what: what.to_string() }
    }
}

impl std::fmt::Display for TrainError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Settings(what) => write!(f, "settings: {what}"),
            Self::File { path, what } => write!(f, "{}: {what}", path.display()),
            Self::Differs(what) => {
                write!(f, "the checkpoint does not match: {what}: undo this change, or train in another folder")
            }
            Self::Diverged { step, mesh, what } => {
                write!(
                    f,
                    "step {step}, mesh {mesh}: {what}: train again in another folder, with a lower `learning_rate` or without this mesh"
                )
            }
            Self::Step(what) => write!(f, "the training step: {what}"),
        }
    }
}

impl std::error::Error for TrainError {}
