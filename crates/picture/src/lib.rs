//! Meshes as pictures, and textures baked from an original.
//!
//! Use it through `neural-mesh`, which has its modules under their names.

#[doc(hidden)]
pub use neural_mesh_measure::metrics;
#[doc(hidden)]
pub use neural_mesh_mesh::{geometry, linalg, mesh, parallel, spatial};

pub mod appearance;
#[cfg(feature = "bake")]
pub mod bake;
pub mod picture;
