//! The simplification of a mesh, by edge collapse or by the paper's network.
//!
//! Use it through `neural-mesh`, which has its modules under their names.

#[cfg(test)]
use neural_mesh_io::io;
#[cfg(test)]
use neural_mesh_measure::metrics;
#[doc(hidden)]
pub use neural_mesh_mesh::{geometry, linalg, mesh, parallel, spatial};
#[doc(hidden)]
pub use neural_mesh_network::{autodiff, model};
#[doc(hidden)]
pub use neural_mesh_repair::repair;

pub mod simplify;
