//! Searches for the smallest mesh within a proved distance, or the largest within a number of bytes.

mod error;
mod placed_original;
mod progress;
mod prove;
mod size;

pub use error::{Bounded, simplify_to_error};
pub use prove::prove_progression;
pub use size::simplify_to_size;
