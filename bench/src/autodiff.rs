//! Derivatives of the library, with shared test helpers.

pub use neural_mesh::autodiff::*;

#[path = "../../src/autodiff/test_gradients.rs"]
pub mod test_gradients;
