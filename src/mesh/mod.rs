//! Triangle meshes that are valid by construction, and what can be asked of them; knows no files, no network.

mod attributes;
pub mod cleanup;
mod compact;
mod edges;
mod first_equal;
mod irregular_edges;
mod manifold;
mod one_rings;
mod point_cloud;
mod polygon;
mod raw_mesh;
mod repeated_faces;
mod seams;
pub mod shapes;
pub(crate) mod shares;
pub mod surface_samples;
mod topology;
mod tri_mesh;
pub(crate) mod union_find;
mod vertex_normals;
mod winding;

pub use attributes::{Attributes, Channel, Role};
pub use compact::compact;
pub use edges::{Edge, edges};
pub use irregular_edges::{IrregularEdges, irregular_edges};
pub use manifold::{Manifold, manifold};
pub use one_rings::{NotManifold, OneRings};
pub use point_cloud::{PointCloud, point_cloud};
pub use polygon::Fans;
pub use raw_mesh::{Frame, RawMesh};
pub use seams::{creases, seams};
pub use topology::{Topology, topology};
pub use tri_mesh::{InvalidMesh, TriMesh};
pub use vertex_normals::vertex_normals;
pub use winding::consistently_wound;
