//! Edge collapse of plain triangle meshes. It stands alone: flat arrays in, flat arrays out.

mod collapse;

pub use collapse::{CollapseError, CollapseResult, Options, Outcome, Record, Size, collapse};
