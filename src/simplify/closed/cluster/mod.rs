//! From many vertices to fewer in one pass: samples, their regions, one vertex for each, and the faces between them.

pub(super) mod cuts;
pub(super) mod darts;
pub(super) mod edge_lengths;
pub(super) mod importance;
pub(super) mod placement;
pub(super) mod quotient;
pub(super) mod sums;
