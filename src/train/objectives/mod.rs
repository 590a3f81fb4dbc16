//! Objectives of trainings by measured results.

mod custom_objective;
mod shape_objective;

pub use custom_objective::{CustomObjective, Errors};
pub use shape_objective::ShapeObjective;

use crate::mesh::TriMesh;
use crate::simplify::WeightedResult;

/// A measure of two results' errors in one unit.
pub trait Objective: Sync {
    /// Judges two results of one mesh.
    ///
    /// # Errors
    /// The reason why the mesh is skipped.
    fn judge(&self, original: &TriMesh, results: [&WeightedResult; 2]) -> Result<JudgedErrors, String>;
}

/// The errors of two results.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgedErrors {
    /// Minimised terms of both results together, as logarithms, with equal names and order for every mesh.
    pub terms: Vec<(&'static str, f64)>,
    /// Excess of the first result's sum of terms over the second's.
    pub error_shares: ErrorShares,
}

/// Distribution of a difference over the original.
#[derive(Clone, Debug, PartialEq)]
pub enum ErrorShares {
    /// Share of each face, n_faces.
    Faces(Vec<f64>),
    /// Share of each vertex, n_vertices.
    Vertices(Vec<f64>),
    /// The whole difference, without location.
    Everywhere(f64),
}
