//! Edge collapse of triangle meshes: flat arrays go in and come out.
//!
//! [`collapse`](collapse()) is the kernel; [`simplify_indices`] is the door for callers with index buffers.

mod collapse;
mod indices;

pub use collapse::{
    BOUNDARY_WEIGHT, CollapseError, CollapseOptions, CollapseOutcome, CollapseRecord, CollapseResult, CollapseSize,
    CollapseTurn, Heartbeat, LEAST_BENDING, MergePlace, PULL, PassListener, PassMerge, StartRing, VOLUME_SHARE,
    collapse, collapse_in_turn,
};
pub use indices::{
    IndexBuffers, IndexOptions, IndexResult, measure_extent, prune_components, select_points, simplify_indices,
    simplify_sloppily, weld,
};
