//! Reasons why a Bevy mesh cannot be simplified.

use std::fmt;

use bevy_mesh::{MeshAccessError, PrimitiveTopology, VertexFormat};
use neural_mesh::mesh::cleanup::CleanError;
use neural_mesh::simplify::SimplifyError;
use neural_mesh_collapse::CollapseError;

/// Reason why a mesh cannot be simplified.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum MeshError {
    /// Mesh whose data is only in the render world.
    Access(MeshAccessError),
    /// Mesh that is no list of triangles.
    Topology(PrimitiveTopology),
    /// Mesh without positions.
    NoPositions,
    /// Attribute in a format that cannot be interpolated.
    Format {
        /// Name of the attribute.
        attribute: &'static str,
        /// Its format.
        format: VertexFormat,
    },
    /// Joint indices without weights, or weights without joint indices.
    HalfSkin,
    /// Attribute with another number of rows than positions.
    Length {
        /// Name of the attribute.
        attribute: &'static str,
        /// Its number of rows.
        n_rows: usize,
        /// Number of vertices.
        n_vertices: usize,
    },
    /// Number of indices that is no multiple of 3.
    IndexCount(usize),
    /// Index of a vertex that does not exist.
    Index {
        /// The index.
        index: u32,
        /// Number of vertices.
        n_vertices: usize,
    },
    /// Mesh without usable triangles, or beyond single precision.
    Clean(CleanError),
    /// Error of the simplifier.
    Simplify(SimplifyError),
    /// Error of the kernel that takes indices.
    Collapse(CollapseError),
    /// Errors of levels that fall, or are negative or not numbers.
    LevelErrors,
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Access(_) => write!(
                f,
                "the mesh is only in the render world: load it with an `asset_usage` that contains `MAIN_WORLD`"
            ),
            Self::Topology(topology) => write!(f, "the mesh is a {topology:?}: make it a `TriangleList` first"),
            Self::NoPositions => write!(f, "the mesh has no attribute Vertex_Position: insert positions"),
            Self::Format { attribute, format } => write!(
                f,
                "the attribute {attribute} has the format {format:?}, which cannot be interpolated: remove it, or simplify before the mesh is compressed"
            ),
            Self::HalfSkin => write!(f, "joint indices and joint weights belong together: insert or remove both"),
            Self::Length { attribute, n_rows, n_vertices } => write!(
                f,
                "the attribute {attribute} has {n_rows} rows for {n_vertices} vertices: give one row for each vertex"
            ),
            Self::IndexCount(n) => write!(f, "{n} indices make no whole triangles: give three for each"),
            Self::Index { index, n_vertices } => {
                write!(
                    f,
                    "an index names vertex {index}, but there are only {n_vertices} vertices: correct the indices"
                )
            }
            Self::Clean(error) => error.fmt(f),
            Self::Simplify(error) => error.fmt(f),
            Self::Collapse(error) => error.fmt(f),
            Self::LevelErrors => write!(f, "errors of levels must be numbers of at least 0 that do not fall"),
        }
    }
}

impl std::error::Error for MeshError {}

impl From<MeshAccessError> for MeshError {
    fn from(error: MeshAccessError) -> Self {
        Self::Access(error)
    }
}

impl From<CleanError> for MeshError {
    fn from(error: CleanError) -> Self {
        Self::Clean(error)
    }
}

impl From<CollapseError> for MeshError {
    fn from(error: CollapseError) -> Self {
        Self::Collapse(error)
    }
}

impl From<SimplifyError> for MeshError {
    fn from(error: SimplifyError) -> Self {
        Self::Simplify(error)
    }
}
