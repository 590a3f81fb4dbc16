//! Objectives of trainings by measured results.

mod custom_objective;
mod shape_objective;

pub use custom_objective::{CustomObjective, Errors};
pub use shape_objective::ShapeObjective;

use crate::mesh::TriMesh;
use crate::simplify::WeightedResult;

/// A measure of how far results are from ideal.
///
/// Results are judged in pairs, so that both sides of a probe have the same unit.
pub trait Objective: Sync {
    /// Judges two results of one mesh.
    ///
    /// # Errors
    /// The reason why they cannot be judged, in a few words; the mesh is skipped.
    fn judge(&self, original: &TriMesh, results: [&WeightedResult; 2]) -> Result<Verdict, String>;
}

/// The errors of two results.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Minimised terms of both results together, as logarithms, with the same names in the same order for every mesh.
    pub terms: Vec<(&'static str, f64)>,
    /// Excess of the first result's sum of terms over the second's.
    pub blame: Blame,
}

/// The distribution of a difference over the original.
#[derive(Clone, Debug, PartialEq)]
pub enum Blame {
    /// The share of each face of the original, n_faces.
    Faces(Vec<f64>),
    /// The share of each vertex of the original, n_vertices.
    Vertices(Vec<f64>),
    /// The whole difference, not located.
    Everywhere(f64),
}
