//! Edge collapse of plain triangle meshes. Flat arrays go in and come out.

mod collapse;

pub use collapse::{
    CollapseError, CollapseOptions, CollapseOutcome, CollapseRecord, CollapseResult, CollapseSize, collapse,
};
