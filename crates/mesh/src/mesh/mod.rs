//! Valid triangle meshes, and queries about them.

mod area;
mod attributes;
pub mod cleanup;
mod common_frame;
mod compact;
mod distinct_keys;
mod edges;
mod facets;
pub mod fallible_allocation;
#[doc(hidden)]
pub mod first_equal;
mod grid;
#[doc(hidden)]
pub mod half_edges;
mod irregular_edges;
mod looks;
mod manifold;
mod non_manifold_edges;
mod one_rings;
mod placed_mesh;
mod point_cloud;
mod polygon_fans;
mod precision;
#[doc(hidden)]
pub mod pulse;
mod raw_mesh;
mod repeated_faces;
mod seams;
pub mod shapes;
mod snap;
pub mod surface_samples;
mod surroundings;
#[doc(hidden)]
pub mod thread_ranges;
mod topology;
mod topology_figures;
mod topology_patch;
mod touching;
mod tri_mesh;
#[doc(hidden)]
pub mod union_find;
mod united_mesh;
#[doc(hidden)]
pub mod value_bytes;
mod vertex_normals;
mod winding;
mod windings;
mod zero_noise;

pub use area::has_area;
pub use attributes::{Attributes, Channel, Role};
pub use common_frame::move_to_common_frame;
pub use compact::compact;
#[doc(hidden)]
pub use distinct_keys::DistinctKeys;
pub use edges::{Edge, edges};
pub use facets::{is_shaded_flat, with_flat_normals};
pub use first_equal::first_equal;
#[doc(hidden)]
pub use first_equal::{PositionKey, join_positions, position_key};
pub use grid::{PositionGrid, longest_side};
pub use irregular_edges::{IrregularEdges, irregular_edges};
pub use looks::{BaseTexture, Finish, Look, Looks, Wrap, linear_light, srgb};
#[doc(hidden)]
pub use manifold::manifold_with;
pub use manifold::{Manifold, manifold};
pub use one_rings::{NotManifold, OneRings};
#[doc(hidden)]
pub use placed_mesh::{PlacedMesh, merge_placed_meshes};
pub use point_cloud::{PointCloud, point_cloud};
pub use polygon_fans::Fans;
pub use raw_mesh::{Frame, RawMesh};
#[doc(hidden)]
pub use repeated_faces::sides;
#[doc(hidden)]
pub use seams::same_values;
pub use seams::{FeatureEdge, creases, seams};
pub use snap::snap;
#[doc(hidden)]
pub use topology::TopologyPatches;
pub use topology::topology;
pub use topology_figures::Topology;
#[doc(hidden)]
pub use topology_patch::TopologyPatch;
pub use tri_mesh::{InvalidMesh, TriMesh};
pub use united_mesh::{ScenePiece, SceneView, UnitedMesh};
#[doc(hidden)]
pub use vertex_normals::sum_face_normals;
pub use vertex_normals::vertex_normals;
pub use winding::orient_outward;
