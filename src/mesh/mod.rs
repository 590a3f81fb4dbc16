//! Triangle meshes that are valid by construction, and queries about them. Knows no files and no network.

mod area;
mod attributes;
pub mod cleanup;
mod compact;
mod edges;
mod facets;
pub(crate) mod first_equal;
mod grid;
pub(crate) mod half_edges;
mod irregular_edges;
mod looks;
mod manifold;
mod non_manifold_edges;
mod one_frame;
mod one_rings;
mod patch;
#[cfg(any(feature = "3mf", feature = "fbx", feature = "gltf"))]
mod placed;
mod point_cloud;
mod polygon;
pub(crate) mod pulse;
mod raw_mesh;
mod repeated_faces;
mod resolved;
pub mod room;
mod seams;
pub mod shapes;
pub(crate) mod shares;
mod sides;
mod snap;
pub mod surface_samples;
mod surroundings;
mod topology;
mod tri_mesh;
pub(crate) mod union_find;
mod united;
mod vertex_normals;
mod winding;

pub use area::has_area;
pub use attributes::{Attributes, Channel, Role};
pub use compact::compact;
pub use edges::{Edge, edges};
pub use facets::{is_shaded_flat, shaded_flat};
pub use first_equal::first_equal;
pub use grid::{Grid, longest_side};
pub use irregular_edges::{IrregularEdges, irregular_edges};
pub use looks::{BaseTexture, Finish, Look, Looks, Wrap, linear_light, srgb};
pub(crate) use manifold::manifold_with;
pub use manifold::{Manifold, manifold};
pub use one_frame::in_one_frame;
pub use one_rings::{NotManifold, OneRings};
#[cfg(feature = "io")]
pub(crate) use patch::Patch;
pub(crate) use patch::{Place, place};
#[cfg(any(feature = "3mf", feature = "fbx", feature = "gltf"))]
pub(crate) use placed::{PlacedMesh, side_by_side};
pub use point_cloud::{PointCloud, point_cloud};
pub use polygon::Fans;
pub use raw_mesh::{Frame, RawMesh};
pub(crate) use seams::same_values;
pub use seams::{KeptEdge, creases, seams};
pub use snap::snap;
#[cfg(feature = "io")]
pub(crate) use topology::Patches;
pub use topology::{Topology, topology};
pub use tri_mesh::{InvalidMesh, TriMesh};
pub use united::{Piece, SceneView, United};
pub use vertex_normals::vertex_normals;
pub use winding::consistently_wound;
