//! Progress of a job.

use std::ops::ControlFlow;

use crate::simplify::Event;

/// Stage of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobStage {
    /// Reading files.
    Read,
    /// Simplification, which reports its own progress.
    Simplify,
    /// Baking textures.
    Bake,
    /// Measuring results.
    Check,
    /// Writing files.
    Write,
    /// Drawing pictures.
    Picture,
}

/// Listener to a job, which can end the job; a closure receives only events.
pub trait Watch: Send {
    /// Receives the start of a stage.
    fn begin(&mut self, stage: JobStage);

    /// Receives the progress of the simplification; returning `Break` ends the job.
    fn event(&mut self, event: Event) -> ControlFlow<()>;
}

impl<F: FnMut(Event) -> ControlFlow<()> + Send> Watch for F {
    fn begin(&mut self, _: JobStage) {}

    fn event(&mut self, event: Event) -> ControlFlow<()> {
        self(event)
    }
}
