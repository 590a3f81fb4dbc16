//! Competing methods behind one interface, and the collapse of plain meshes, which is not behind the program.

mod ball_pivoting;
mod collapse;
mod error;
mod meshoptimizer;
mod planes;
mod qem;
mod sampled;

use neural_mesh::mesh::TriMesh;
use qem::qem;
use sampled::{farthest_ball_pivoting, uniform_ball_pivoting};

pub use ball_pivoting::ball_pivoting;
pub use error::BaselineError;
pub use meshoptimizer::meshoptimizer_faces;

/// A competing method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Baseline {
    /// Edge collapse (Garland and Heckbert 1997).
    Qem,
    /// The collapse of plain meshes, without a fit.
    Collapse,
    /// The collapse of plain meshes, with two fit steps.
    CollapseFitted,
    /// meshoptimizer's `simplify`.
    Meshoptimizer,
    /// meshoptimizer's `simplifyWithUpdate`, which also moves remaining vertices.
    MeshoptimizerUpdate,
    /// Farthest points (Eldar et al. 1997) and ball pivoting.
    FarthestBallPivoting,
    /// Uniformly drawn vertices and ball pivoting.
    UniformBallPivoting,
}

impl Baseline {
    /// All methods.
    pub const ALL: [Self; 7] = [
        Self::Qem,
        Self::Collapse,
        Self::CollapseFitted,
        Self::Meshoptimizer,
        Self::MeshoptimizerUpdate,
        Self::FarthestBallPivoting,
        Self::UniformBallPivoting,
    ];

    /// Returns the name in tables and arguments.
    pub fn name(self) -> &'static str {
        match self {
            Self::Qem => "qem",
            Self::Collapse => "collapse",
            Self::CollapseFitted => "collapse-fitted",
            Self::Meshoptimizer => "meshopt",
            Self::MeshoptimizerUpdate => "meshopt-update",
            Self::FarthestBallPivoting => "farthest-bpa",
            Self::UniformBallPivoting => "uniform-bpa",
        }
    }

    /// Returns the method with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|baseline| baseline.name() == name)
    }
}

/// Target size; QEM, the collapse and meshoptimizer use the number of faces, the others that of vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TargetCounts {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
}

/// Simplifies a mesh by one of the methods, some of which draw points by `seed`.
///
/// Results miss the target size where a method gets stuck.
///
/// # Errors
/// [`BaselineError::Empty`] for an input without faces, [`BaselineError::NothingLeft`] for such a result.
pub fn simplify_by(
    baseline: Baseline,
    mesh: &TriMesh,
    size: TargetCounts,
    seed: u64,
) -> Result<TriMesh, BaselineError> {
    if mesh.faces().is_empty() {
        return Err(BaselineError::Empty);
    }
    let simplified = match baseline {
        Baseline::Qem => qem(mesh, size.faces),
        Baseline::Collapse => collapse::simplify(mesh, size.faces, 0),
        Baseline::CollapseFitted => collapse::simplify(mesh, size.faces, 2),
        Baseline::Meshoptimizer => meshoptimizer::simplify(mesh, size.faces),
        Baseline::MeshoptimizerUpdate => meshoptimizer::simplify_updating(mesh, size.faces),
        Baseline::FarthestBallPivoting => farthest_ball_pivoting(mesh, size.vertices, seed),
        Baseline::UniformBallPivoting => uniform_ball_pivoting(mesh, size.vertices, seed),
    }?;
    if simplified.faces().is_empty() { Err(BaselineError::NothingLeft) } else { Ok(simplified) }
}
