//! Holes filled, broken meshes made solid.
//!
//! Use it through `neural-mesh`, which has its modules under their names.

#[cfg(test)]
use neural_mesh_measure::metrics;
#[doc(hidden)]
pub use neural_mesh_mesh::{geometry, linalg, mesh, parallel, spatial};

pub mod repair;
