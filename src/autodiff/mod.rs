//! Reverse-mode differentiation over rank-2 matrices: a small tape, forward and backward side by side.
//!
//! An operation none of whose inputs depends on a parameter records nothing, so the code that trains is also the
//! fast path of inference.
//!
//! Machinery: what the modules that users call stand on; see the front page of the crate.

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
