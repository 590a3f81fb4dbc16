//! The closed assembly under a chosen importance, whole or without one of its parts.

use std::time::Instant;

use anyhow::Result;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::model::Weights;
use neural_mesh::simplify::{Importance, Parts, simplify_weighed};

use super::bending::bending_importance;
use crate::methods::{Done, compact};
use crate::turns::Case;

/// Where the importance of the vertices comes from.
#[derive(Clone, Copy)]
pub enum Source<'a> {
    /// All count alike.
    Even,
    /// The network.
    Network(&'a Weights),
    /// How much the surface bends.
    Bending,
}

/// Simplifies from parsed arrays, as the pipeline does.
pub fn weighed(case: &Case, source: Source, parts: &Parts) -> Result<Done> {
    let raw = case.original.raw.clone();
    let start = Instant::now();
    let cleaned = clean(raw, &CleanOptions::default())?.mesh;
    let mesh = compact(&cleaned, cleaned.faces())?;
    let n_vertices = ((mesh.positions().len() as f64 * case.ratio) as usize).max(1);
    let factors;
    let importance = match source {
        Source::Even => Importance::Even,
        Source::Network(weights) => Importance::Network(weights),
        Source::Bending => {
            factors = bending_importance(&mesh);
            Importance::Given(&factors)
        }
    };
    let lighter = simplify_weighed(&mesh, n_vertices, importance, case.seed, parts)?.mesh;
    let seconds = start.elapsed().as_secs_f64();
    let reached = lighter.positions().len() <= n_vertices;
    let outcome = if reached { "reached" } else { "stopped" }.to_owned();
    Ok(Done { outcome, ..Done::reached(lighter, seconds) })
}
