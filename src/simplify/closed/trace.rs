//! What a run wrote down, so that its result is known as a function of the positions.

use super::collapse::Event;
use super::refine::points::{Density, Match};

/// What a run chose on its way, as far as its result depends on positions.
#[derive(Default)]
pub struct Trace {
    /// What happened in the collapse, in order.
    pub history: Vec<Event>,
    /// The faces that were fitted.
    pub faces: Vec<[u32; 3]>,
    /// The steps of the fit.
    pub steps: Vec<Step>,
}

/// A step of the fit as it was taken.
pub struct Step {
    /// How many points there were on a face.
    pub density: Density,
    /// The points and where they belonged.
    pub matches: Vec<Match>,
    /// For each output face how much its points count.
    pub counts: Vec<f32>,
    /// For each output vertex whether it moved.
    pub moved: Vec<bool>,
    /// Weight of staying in place against the points.
    pub stay: f32,
}
