//! What a training by measured results makes small: each objective in a file of its own, and any function of one's own.

mod given;
mod shape;

pub use given::{Errors, Given};
pub use shape::Shape;

use crate::mesh::TriMesh;
use crate::simplify::WeightedResult;

/// How far results are from what they should be.
///
/// Results are judged in pairs, since both sides of a probe are measured in the same unit.
pub trait Objective: Sync {
    /// Judges two results of one mesh.
    ///
    /// # Errors
    /// In a few words why these cannot be judged; the mesh is then named and passed over.
    fn judge(&self, original: &TriMesh, results: [&WeightedResult; 2]) -> Result<Verdict, String>;
}

/// What is wrong with two results.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// What is minimised, of both results together, by name: logarithms of errors, so that one percent counts the same in each.
    /// The same names in the same order for every mesh.
    pub terms: Vec<(&'static str, f64)>,
    /// By how much the sum of the terms is larger for the first result than for the second.
    pub blame: Blame,
}

/// Who is to blame for a difference.
#[derive(Clone, Debug, PartialEq)]
pub enum Blame {
    /// The share of each face of the original, n_faces.
    Faces(Vec<f64>),
    /// The share of each vertex of the original, n_vertices.
    Vertices(Vec<f64>),
    /// All places alike: the whole difference.
    Everywhere(f64),
}
