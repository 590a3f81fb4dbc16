//! Objectives of trainings by measured results.

mod custom_objective;
mod shape_objective;

pub use custom_objective::{CustomObjective, Errors};
pub use shape_objective::ShapeObjective;

use crate::mesh::TriMesh;
use crate::simplify::WeightedResult;

/// A measure that compares the errors of two results of one mesh.
pub trait Objective: Sync {
    /// Judges two results of one mesh.
    ///
    /// # Errors
    /// The reason why the mesh is skipped.
    fn judge(&self, original: &TriMesh, results: [&WeightedResult; 2]) -> Result<JudgedErrors, String>;
}

/// Comparison of the errors of two results.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgedErrors {
    /// Minimised terms by name: logarithms of errors averaged over both results, in a fixed order.
    pub terms: Vec<(&'static str, f64)>,
    /// Sum of the first result's terms minus that of the second's, by place on the original.
    pub error_shares: ErrorShares,
}

/// Difference between two results' errors, split over faces or vertices of the original.
#[derive(Clone, Debug, PartialEq)]
pub enum ErrorShares {
    /// Share of each face, n_faces.
    Faces(Vec<f64>),
    /// Share of each vertex, n_vertices.
    Vertices(Vec<f64>),
    /// The whole difference, without location.
    Everywhere(f64),
}
