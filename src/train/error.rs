//! Why a training does not begin or go on, in one line each.

use std::path::{Path, PathBuf};

/// Why a training does not begin or go on.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TrainError {
    /// A setting is unknown or out of range; the text names it.
    Settings(String),
    /// A file or folder; the text says what is wrong with it and what to do.
    File {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong and what to do.
        what: String,
    },
    /// A checkpoint that was made with something else; the text names the difference.
    Differs(String),
    /// A loss or a gradient that is not finite, or a loss that explodes.
    Diverged {
        /// Counted from 1, over all epochs.
        step: u64,
        /// The file of the mesh.
        mesh: String,
        /// The term or the tensor, and what happened to it.
        what: String,
    },
    /// The step function does not keep its promise; the text says which.
    Step(String),
}

impl TrainError {
    /// An error about a file.
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
                write!(f, "the checkpoint does not match: {what}: use the same again, or start over")
            }
            Self::Diverged { step, mesh, what } => {
                write!(f, "step {step}, mesh {mesh}: {what}: lower `learning_rate`, or look at the mesh")
            }
            Self::Step(what) => write!(f, "the training step: {what}"),
        }
    }
}

impl std::error::Error for TrainError {}
