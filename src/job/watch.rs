//! Who hears how far a job is.

use std::ops::ControlFlow;

use crate::simplify::Event;

/// A part of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Files become meshes.
    Read,
    /// The simplification, which says itself how far it is.
    Simplify,
    /// Textures of the original for the result.
    Bake,
    /// Results are measured.
    Check,
    /// Meshes become files.
    Write,
    /// They are drawn.
    Picture,
}

/// Hears how far a job is, and may end it. A closure over events is one that does not care for parts.
pub trait Watch: Send {
    /// Hears that a part begins.
    fn begin(&mut self, part: Part);

    /// Hears of the simplification; `Break` ends the job.
    fn event(&mut self, event: Event) -> ControlFlow<()>;
}

impl<F: FnMut(Event) -> ControlFlow<()> + Send> Watch for F {
    fn begin(&mut self, _: Part) {}

    fn event(&mut self, event: Event) -> ControlFlow<()> {
        self(event)
    }
}
