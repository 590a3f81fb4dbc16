//! The smallest mesh that holds what was asked: a largest distance from the original, or a size in bytes.
//!
//! The simplifier is asked for a number of vertices; which number it takes is found here, by trying.

mod error;
mod part;
mod size;

pub use error::{Bounded, simplify_to_error};
pub use size::simplify_to_size;
