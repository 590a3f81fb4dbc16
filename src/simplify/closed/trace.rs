//! Record of a run's choices, from which its derivative is computed.

use super::collapse::CollapseEvent;
use super::refine::points::{Density, Match};

/// Choices of a run that its result depends on.
#[derive(Default)]
pub struct Trace {
    /// Events of the collapse, in order.
    pub history: Vec<CollapseEvent>,
    /// Faces during the fit.
    pub faces: Vec<[u32; 3]>,
    /// Steps of the fit.
    pub steps: Vec<TracedStep>,
}

/// One step of the fit.
pub struct TracedStep {
    /// Points per face.
    pub density: Density,
    /// Points with their output faces.
    pub matches: Vec<Match>,
    /// Weight of each output face's points.
    pub counts: Vec<f32>,
    /// Output vertices that moved.
    pub moved: Vec<bool>,
    pub stay: f32,
}
