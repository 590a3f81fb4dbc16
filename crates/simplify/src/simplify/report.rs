//! Initial report of every run.

use crate::mesh::TriMesh;
use crate::mesh::pulse::Pulse;

use super::components::count_components;
use super::options::{Outcome, Report, ScoreSource};

impl Report {
    pub(super) fn for_mesh(pulse: Pulse, mesh: &TriMesh) -> Self {
        Self {
            outcome: Outcome::Reached,
            scores: ScoreSource::Network,
            components_at_minimum: count_components(pulse, mesh).1,
            size_with_shape: None,
            components_pruned: 0,
            components_hidden: 0,
            dropped: Vec::new(),
            kept_edges: 0,
            locked_vertices: 0,
            split_vertices: 0,
            flipped_edges: 0,
            separated_vertices: 0,
            shortened_spikes: 0,
        }
    }
}
