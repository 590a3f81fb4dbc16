//! Events of a training, and the caller's answers.

/// An event of a training.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum TrainEvent<'a> {
    /// A step is done.
    Step {
        /// Number of epochs done before this one.
        epoch: usize,
        /// Number of steps done in this epoch.
        n_done: usize,
        /// Number of steps in an epoch.
        n_steps: usize,
        /// The loss terms by name.
        terms: &'a [(&'static str, f64)],
    },
    /// A mesh was skipped.
    Skipped {
        /// Name of the mesh's file.
        mesh: &'a str,
        /// Reason why the mesh was skipped.
        why: &'a str,
    },
    /// A validation mesh was measured.
    Validated {
        /// Number of epochs done before this one.
        epoch: usize,
        /// Number of meshes measured so far.
        n_done: usize,
        /// Number of validation meshes.
        n_meshes: usize,
    },
    /// An epoch is done.
    Epoch {
        /// Number of epochs done, this one included.
        n_done: usize,
        /// Mean summed loss of the epoch's steps.
        training: f64,
        /// Mean summed loss of the validation, if any.
        validation: Option<f64>,
        /// True if the weights are the best so far.
        is_best: bool,
    },
}

/// The caller's answer to an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Continue.
    Continue,
    /// Write a checkpoint and continue.
    Checkpoint,
    /// Write a checkpoint and stop.
    Stop,
    /// Stop at the last checkpoint; later work is lost.
    Abandon,
}

/// The way a training ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// All epochs are done.
    Finished,
    /// The caller stopped the training.
    Stopped,
}
