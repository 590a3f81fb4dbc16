//! The network of Neural Mesh Simplification, reverse-mode differentiation and the terms of training.
//!
//! Use it through `neural-mesh`, which has its modules under their names.

#[doc(hidden)]
pub use neural_mesh_mesh::{geometry, linalg, mesh, parallel, spatial};

pub mod autodiff;
#[cfg(feature = "loss")]
pub mod loss;
pub mod model;
