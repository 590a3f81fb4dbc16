//! Reverse-mode differentiation over matrices.
//!
//! Operations on constants record nothing. Operations panic if shapes do not match or an index is out of range. Support code
//! for the main modules; see the front page of the crate.

mod dense;
mod graph;
mod group_distances;
mod pooled;
mod tape;
mod tensors;
#[cfg(feature = "weights")]
mod tensors_file;
#[cfg(test)]
pub(crate) mod test_gradients;
mod weights_error;

pub use tape::{Gradients, Tape, Value};
pub use tensors::Tensors;
#[cfg(feature = "weights")]
pub use tensors_file::architecture_text;
pub use weights_error::WeightsError;
