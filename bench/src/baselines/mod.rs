//! The methods that neural-mesh is measured against, behind one interface; knows no network and no metric.
//!
//! One file or folder per method. Each takes the mesh and a size, and stops short where it can go no further.

mod ball_pivoting;
mod clustering;
mod error;
mod meshoptimizer;
mod planes;
mod qem;
mod sampled;

use clustering::clustering;
use neural_mesh::mesh::TriMesh;
use qem::qem;
use sampled::{farthest_ball_pivoting, uniform_ball_pivoting};

pub use ball_pivoting::ball_pivoting;
pub use error::BaselineError;
pub use meshoptimizer::meshoptimizer_faces;

/// A method of others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Baseline {
    /// Edge collapse by quadrics with optimal placement (Garland and Heckbert 1997).
    Qem,
    /// meshoptimizer's `simplify`, without options or error limit.
    Meshoptimizer,
    /// meshoptimizer's `simplifyWithUpdate`, which also moves the vertices that stay.
    MeshoptimizerUpdate,
    /// meshoptimizer's `simplifySloppy`, which does not keep the topology.
    MeshoptimizerSloppy,
    /// Vertex clustering in a uniform grid (Rossignac and Borrel 1993).
    Clustering,
    /// Farthest points (Eldar et al. 1997), meshed by ball pivoting (Bernardini et al. 1999).
    FarthestBallPivoting,
    /// Vertices drawn with equal probability, meshed by ball pivoting.
    UniformBallPivoting,
}

impl Baseline {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Qem,
        Self::Meshoptimizer,
        Self::MeshoptimizerUpdate,
        Self::MeshoptimizerSloppy,
        Self::Clustering,
        Self::FarthestBallPivoting,
        Self::UniformBallPivoting,
    ];

    /// The name in tables and arguments.
    ///
    /// ```
    /// assert_eq!(neural_mesh_bench::baselines::Baseline::Qem.name(), "qem");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Qem => "qem",
            Self::Meshoptimizer => "meshopt",
            Self::MeshoptimizerUpdate => "meshopt-update",
            Self::MeshoptimizerSloppy => "meshopt-sloppy",
            Self::Clustering => "clustering",
            Self::FarthestBallPivoting => "farthest-bpa",
            Self::UniformBallPivoting => "uniform-bpa",
        }
    }

    /// The method of that name.
    ///
    /// ```
    /// use neural_mesh_bench::baselines::Baseline;
    /// assert_eq!(Baseline::from_name("farthest-bpa"), Some(Baseline::FarthestBallPivoting));
    /// assert_eq!(Baseline::from_name("magic"), None);
    /// ```
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|baseline| baseline.name() == name)
    }
}

/// The size asked for. QEM and meshoptimizer's simplifiers go by the faces, the others by the vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Vertices.
    pub vertices: usize,
    /// Faces.
    pub faces: usize,
}

/// Simplifies a mesh by one of the methods.
///
/// The seed matters where points are drawn: the first of the farthest ones, all of the uniform ones. The result has
/// no vertices without faces. Edge collapse and sampling end at the size or below, and above it only where they can go
/// no further; clustering ends as near to it as a grid does.
///
/// # Errors
/// [`BaselineError::Empty`] where the mesh has no faces, [`BaselineError::NothingLeft`] where the method left none.
///
/// ```
/// use neural_mesh_bench::baselines::{Baseline, Size, simplify_by};
/// let sphere = neural_mesh::mesh::shapes::icosphere(3);
/// let lighter = simplify_by(Baseline::Qem, &sphere, Size { vertices: 66, faces: 128 }, 0).unwrap();
/// assert_eq!(lighter.faces().len(), 128);
/// ```
pub fn simplify_by(baseline: Baseline, mesh: &TriMesh, size: Size, seed: u64) -> Result<TriMesh, BaselineError> {
    if mesh.faces().is_empty() {
        return Err(BaselineError::Empty);
    }
    let lighter = match baseline {
        Baseline::Qem => qem(mesh, size.faces),
        Baseline::Meshoptimizer => meshoptimizer::simplified(mesh, size.faces),
        Baseline::MeshoptimizerUpdate => meshoptimizer::updated(mesh, size.faces),
        Baseline::MeshoptimizerSloppy => meshoptimizer::sloppy(mesh, size.faces),
        Baseline::Clustering => clustering(mesh, size.vertices),
        Baseline::FarthestBallPivoting => farthest_ball_pivoting(mesh, size.vertices, seed),
        Baseline::UniformBallPivoting => uniform_ball_pivoting(mesh, size.vertices, seed),
    }?;
    if lighter.faces().is_empty() { Err(BaselineError::NothingLeft) } else { Ok(lighter) }
}
