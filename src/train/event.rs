//! What a caller hears of a training, what it answers, and how a training ends.

/// What a caller hears of.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event<'a> {
    /// A step was made.
    Step {
        /// Epochs done before this one.
        epoch: usize,
        /// Steps done in this epoch.
        n_done: usize,
        /// Steps of an epoch.
        n_steps: usize,
        /// The loss terms by name.
        terms: &'a [(&'static str, f64)],
    },
    /// A mesh could not be used in a step, for the reason given.
    PassedOver {
        /// Name of its file.
        mesh: &'a str,
        /// Why.
        why: &'a str,
    },
    /// A mesh of the validation was measured.
    Validated {
        /// Epochs done before this one.
        epoch: usize,
        /// Meshes measured after this epoch, at all ratios.
        n_done: usize,
        /// Meshes of the validation.
        n_meshes: usize,
    },
    /// An epoch is done.
    Epoch {
        /// Epochs done, with this one.
        n_done: usize,
        /// Mean total of its steps.
        training: f64,
        /// Mean total of the validation, where there is one.
        validation: Option<f64>,
        /// Whether its weights are the best so far.
        is_best: bool,
    },
}

/// What a caller answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Go on.
    Continue,
    /// Write a checkpoint, then go on.
    Checkpoint,
    /// Write a checkpoint and stop.
    Stop,
    /// Stop where the last checkpoint is: what came after it is done again.
    Abandon,
}

/// How a training ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// All epochs are done.
    Finished,
    /// The caller wished so; the checkpoint has all that was done, unless it was to be abandoned.
    Stopped,
}
