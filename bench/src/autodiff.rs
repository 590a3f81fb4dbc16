//! Derivatives of the library, with shared test helpers.

pub use neural_mesh::autodiff::*;

#[path = "../../crates/network/src/autodiff/test_gradients.rs"]
pub mod test_gradients;
