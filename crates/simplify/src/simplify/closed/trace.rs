//! Record of a run's choices, for its derivative.

use super::collapse::CollapseEvent;
use super::refine::sample_points::{Density, Match};

#[derive(Default)]
pub struct Trace {
    pub history: Vec<CollapseEvent>,
    pub faces: Vec<[u32; 3]>,
    pub steps: Vec<TracedStep>,
}

pub struct TracedStep {
    pub density: Density,
    pub matches: Vec<Match>,
    pub face_weights: Vec<f32>,
    pub moved: Vec<bool>,
    pub stay: f32,
}
