//! The methods of others that learn, as far as neural-mesh is measured against them: networks, losses, steps of training, inference.
//!
//! One folder per method. Each network is made of named tensors, so that `neural_mesh::train` trains it by the loop that trains
//! ours; each method makes a mesh of a mesh and a number of vertices, so that `evaluate` measures it like the others.

pub mod dse;
mod error;
pub mod pointtrinet;
pub mod potamias;
mod training;
mod weights;

use neural_mesh::autodiff::Tensors;
use neural_mesh::linalg::Matrix;
use neural_mesh::mesh::TriMesh;
use std::sync::Arc;

pub use error::LearnedBaselineError;
pub use weights::LearnedWeights;

/// A method of others that learns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LearnedBaseline {
    /// Points drawn from the mesh, Delaunay triangulations of learned logarithmic maps at them (Rakotosaona et al. 2021).
    Dse,
    /// Points drawn in a latent space and moved (Potamias, Bouritsas and Zafeiriou 2022), meshed by ball pivoting.
    Potamias,
    /// Triangles over points, classified and proposed by turns (Sharp and Ovsjanikov 2020).
    PointTriNet,
}

impl LearnedBaseline {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Dse, Self::Potamias, Self::PointTriNet];

    /// The name in tables and arguments, and that of the objective which trains it.
    ///
    /// ```
    /// assert_eq!(neural_mesh_bench::learned_baselines::LearnedBaseline::Potamias.name(), "potamias");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Dse => "dse",
            Self::Potamias => "potamias",
            Self::PointTriNet => "pointtrinet",
        }
    }

    /// The method of that name.
    ///
    /// ```
    /// use neural_mesh_bench::learned_baselines::LearnedBaseline;
    /// assert_eq!(LearnedBaseline::from_name("potamias"), Some(LearnedBaseline::Potamias));
    /// assert_eq!(LearnedBaseline::from_name("magic"), None);
    /// ```
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|baseline| baseline.name() == name)
    }

    /// The shapes of its network's tensors, the widths times a share of the full ones, above 0 and at most 1.
    ///
    /// ```
    /// use neural_mesh_bench::learned_baselines::LearnedBaseline;
    /// let [full, half] = [1.0, 0.5].map(|share| LearnedBaseline::Potamias.shapes(share).n_parameters());
    /// assert!(half < full / 3);
    /// ```
    pub fn shapes(self, width_share: f64) -> Tensors<[usize; 2]> {
        match self {
            Self::Dse => dse::shapes(width_share),
            Self::Potamias => potamias::shapes(width_share),
            Self::PointTriNet => pointtrinet::shapes(width_share),
        }
    }

    /// The tensors that its training begins with.
    pub fn drawn(self, width_share: f64, seed: u64) -> Tensors<Arc<Matrix>> {
        match self {
            Self::Dse => dse::drawn(width_share, seed),
            Self::Potamias => potamias::drawn(width_share, seed),
            Self::PointTriNet => pointtrinet::drawn(width_share, seed),
        }
    }
}

/// Simplifies a mesh to at most `n_vertices` by the method of these weights.
///
/// The result has no vertices without faces. The seed decides which point is drawn first.
///
/// # Errors
/// [`LearnedBaselineError`] where the method leaves no face, or nothing that is a mesh.
///
/// ```
/// use neural_mesh_bench::learned_baselines::{LearnedBaseline, LearnedWeights, simplify_by_learned};
/// let sphere = neural_mesh::mesh::shapes::icosphere(3);
/// let weights = LearnedWeights::shipped(LearnedBaseline::Potamias);
/// let lighter = simplify_by_learned(weights, &sphere, 160, 0).unwrap();
/// assert!((100..=160).contains(&lighter.positions().len()));
/// ```
pub fn simplify_by_learned(
    weights: &LearnedWeights,
    mesh: &TriMesh,
    n_vertices: usize,
    seed: u64,
) -> Result<TriMesh, LearnedBaselineError> {
    let lighter = match weights.baseline() {
        LearnedBaseline::Dse => dse::remeshed(mesh, n_vertices, seed, dse::Maps::Learned(weights.tensors())),
        LearnedBaseline::Potamias => potamias::simplified(mesh, n_vertices, seed, weights.tensors()),
        LearnedBaseline::PointTriNet => pointtrinet::simplified(mesh, n_vertices, seed, weights.tensors()),
    }?;
    if lighter.faces().is_empty() { Err(LearnedBaselineError::NothingLeft) } else { Ok(lighter) }
}

/// A share of a width, at least 1.
fn share_of(width: usize, share: f64) -> usize {
    ((width as f64 * share).round() as usize).max(1)
}
