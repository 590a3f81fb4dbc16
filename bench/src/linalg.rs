//! Matrices of the library, with shared test helpers.

pub use neural_mesh::linalg::*;

#[expect(dead_code, reason = "some of it is for the library's tests alone")]
#[path = "../../crates/mesh/src/linalg/test_values.rs"]
pub mod test_values;
