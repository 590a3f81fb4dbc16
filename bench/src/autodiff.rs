//! Derivatives of the library, with what its tests of them share.

pub use neural_mesh::autodiff::*;

#[path = "../../src/autodiff/test_gradients.rs"]
pub mod test_gradients;
