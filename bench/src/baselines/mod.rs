//! Competing methods behind one interface.

mod ball_pivoting;
mod meshoptimizer;
mod points;
mod qem;
mod sampled;

use anyhow::{Result, ensure};
use neural_mesh::mesh::TriMesh;
use qem::qem;
use sampled::{farthest_ball_pivoting, uniform_ball_pivoting};

pub use ball_pivoting::ball_pivoting;
pub use meshoptimizer::meshoptimizer_faces;
pub(crate) use sampled::points_and_normals;

/// A competing method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Baseline {
    /// Edge collapse (Garland and Heckbert 1997).
    Qem,
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
    pub const ALL: [Self; 5] = [
        Self::Qem,
        Self::Meshoptimizer,
        Self::MeshoptimizerUpdate,
        Self::FarthestBallPivoting,
        Self::UniformBallPivoting,
    ];

    /// Returns the name in tables and arguments.
    pub fn name(self) -> &'static str {
        ["qem", "meshopt", "meshopt-update", "farthest-bpa", "uniform-bpa"][self as usize]
    }

    /// Returns the method with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|baseline| baseline.name() == name)
    }
}

/// Target size; QEM and meshoptimizer use the number of faces, the others that of vertices.
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
/// One line for an input or a result without faces.
pub fn simplify_by(baseline: Baseline, mesh: &TriMesh, size: TargetCounts, seed: u64) -> Result<TriMesh> {
    ensure!(!mesh.faces().is_empty(), "the mesh has no faces: there is nothing to simplify");
    let simplified = match baseline {
        Baseline::Qem => qem(mesh, size.faces),
        Baseline::Meshoptimizer => meshoptimizer::simplify(mesh, size.faces),
        Baseline::MeshoptimizerUpdate => meshoptimizer::simplify_updating(mesh, size.faces),
        Baseline::FarthestBallPivoting => farthest_ball_pivoting(mesh, size.vertices, seed),
        Baseline::UniformBallPivoting => uniform_ball_pivoting(mesh, size.vertices, seed),
    }?;
    check_has_faces(simplified)
}

pub(crate) fn check_has_faces(simplified: TriMesh) -> Result<TriMesh> {
    ensure!(!simplified.faces().is_empty(), "the method left no face: ask for a larger mesh");
    Ok(simplified)
}
