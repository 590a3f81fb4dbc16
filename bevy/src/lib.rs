//! Simplifies meshes of [Bevy](https://bevy.org): closed and manifold in, closed and manifold out.
//!
//! | to get | call |
//! |---|---|
//! | a smaller mesh with all attributes | [`simplify_mesh`], [`simplify_mesh_to_error`] |
//! | fewer triangles over the same vertices, while a game runs | [`simplify_indices`] |
//! | levels of detail with their [`VisibilityRange`](bevy_camera::visibility::VisibilityRange) | [`make_levels`], [`spawn_levels`] |
//! | meshes simplified while assets are processed | [`MeshSimplifier`]; for glTF files `GltfSimplifierPlugin` |
//!
//! ```
//! use bevy_mesh::{Indices, Mesh, PrimitiveTopology};
//! use neural_mesh_bevy::{ClosedOptions, Size, simplify_mesh};
//! # let (positions, faces) = neural_mesh::mesh::shapes::icosphere(3).into_parts();
//! # let mesh = Mesh::new(PrimitiveTopology::TriangleList, Default::default())
//! #     .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
//! #     .with_inserted_indices(Indices::U32(faces.into_flattened()));
//!
//! // A tenth of the vertices; `mesh` is any list of triangles.
//! let light = simplify_mesh(&mesh, Size::Ratio(0.1), &ClosedOptions::default())?.mesh;
//! assert_eq!((mesh.count_vertices(), light.count_vertices()), (642, 64));
//! # Ok::<(), neural_mesh_bevy::MeshError>(())
//! ```
//!
//! The functions work on the current rayon pool and block until they are done: call them in a task
//! (`AsyncComputeTaskPool`), not in a system that runs each frame.

mod error;
mod indices;
mod levels;
mod mesh_source;
mod processing;
mod ranges;
mod result_mesh;
mod screen;
mod simplify;
mod spawn;
mod vertex_values;
mod wedges;

pub use error::MeshError;
pub use indices::simplify_indices;
pub use levels::{Level, LevelOptions, LevelSizes, make_levels};
pub use processing::*;
pub use ranges::visibility_ranges;
pub use screen::Screen;
pub use simplify::{SimplifiedMesh, simplify_mesh, simplify_mesh_to_error};
pub use spawn::spawn_levels;

pub use neural_mesh::simplify::{ClosedOptions, Outcome, Report, Size};

// The examples of the README are tested like all others.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
