//! Learned methods of others, one folder per method.

pub mod dse;
pub mod pointtrinet;
pub mod potamias;
mod training;
mod weights;

use crate::baselines::BaselineError;
use neural_mesh::autodiff::{Tensors, Value};
use neural_mesh::linalg::Matrix;
use neural_mesh::mesh::{TriMesh, compact};
use std::sync::Arc;

pub use weights::LearnedWeights;

/// A learned method of others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LearnedBaseline {
    /// Delaunay surface elements (Rakotosaona et al. 2021).
    Dse,
    /// Points drawn in a latent space (Potamias, Bouritsas and Zafeiriou 2022).
    Potamias,
    /// Triangles proposed in rounds (Sharp and Ovsjanikov 2020).
    PointTriNet,
}

impl LearnedBaseline {
    /// All learned methods.
    pub const ALL: [Self; 3] = [Self::Dse, Self::Potamias, Self::PointTriNet];

    /// Returns the name in tables and arguments, and of the training objective.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dse => "dse",
            Self::Potamias => "potamias",
            Self::PointTriNet => "pointtrinet",
        }
    }

    /// Returns the method with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|baseline| baseline.name() == name)
    }

    /// Returns the shapes of the tensors; `width_share` is in (0, 1].
    pub fn shapes(self, width_share: f64) -> Tensors<[usize; 2]> {
        match self {
            Self::Dse => dse::shapes(width_share),
            Self::Potamias => potamias::shapes(width_share),
            Self::PointTriNet => pointtrinet::shapes(width_share),
        }
    }

    /// Returns random initial tensors.
    pub fn initial_tensors(self, width_share: f64, seed: u64) -> Tensors<Arc<Matrix>> {
        match self {
            Self::Dse => dse::initial_tensors(width_share, seed),
            Self::Potamias => potamias::initial_tensors(width_share, seed),
            Self::PointTriNet => pointtrinet::initial_tensors(width_share, seed),
        }
    }
}

/// Simplifies a mesh to at most `n_vertices`; the seed chooses the first point.
///
/// # Errors
/// [`BaselineError`] where the result has no face or is no mesh.
pub fn simplify_by_learned(
    weights: &LearnedWeights,
    mesh: &TriMesh,
    n_vertices: usize,
    seed: u64,
) -> Result<TriMesh, BaselineError> {
    let simplified = match weights.baseline() {
        LearnedBaseline::Dse => dse::simplify(mesh, n_vertices, seed, weights.tensors()),
        LearnedBaseline::Potamias => potamias::simplify(mesh, n_vertices, seed, weights.tensors()),
        LearnedBaseline::PointTriNet => pointtrinet::simplify(mesh, n_vertices, seed, weights.tensors()),
    }?;
    if simplified.faces().is_empty() { Err(BaselineError::NothingLeft) } else { Ok(simplified) }
}

/// Returns a tensor of checked weights by name.
///
/// # Panics
/// If there is none of this name; [`LearnedWeights`] have all of their network.
fn tensor<'a>(tensors: &'a Tensors<Value>, name: &str) -> &'a Value {
    tensors.find_tensor(name).expect("the tensors of this network")
}

/// Returns weights and bias of a layer.
fn layer<'a>(tensors: &'a Tensors<Value>, name: &str) -> [&'a Value; 2] {
    [".weights", ".bias"].map(|of| tensor(tensors, &format!("{name}{of}")))
}

/// Returns the first `n` layers `name_0`, `name_1`, and so on.
fn layers<'a>(tensors: &'a Tensors<Value>, name: &str, n: usize) -> Vec<[&'a Value; 2]> {
    (0..n).map(|i| layer(tensors, &format!("{name}_{i}"))).collect()
}

fn scale_width(width: usize, share: f64) -> usize {
    ((width as f64 * share).round() as usize).max(1)
}

fn compact_with_first_point(mesh: &TriMesh, seed: u64) -> Result<(TriMesh, u32), BaselineError> {
    let (mesh, _) = compact(mesh.positions(), mesh.faces().to_vec())?;
    match mesh.positions().len() as u64 {
        0 => Err(BaselineError::NothingLeft),
        n => Ok((mesh, (seed % n) as u32)),
    }
}
