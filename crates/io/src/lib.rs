//! Mesh and scene files to meshes and back.
//!
//! Use it through `neural-mesh`, which has its modules under their names.

#[doc(hidden)]
pub use neural_mesh_mesh::{geometry, linalg, mesh, parallel, spatial};

pub mod io;
