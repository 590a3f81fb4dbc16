//! From many vertices to fewer in one pass: samples, their regions, one vertex for each, and the faces between them.

pub mod assignment;
mod cuts;
mod darts;
mod edge_lengths;
pub mod importance;
pub mod placement;
pub mod quotient;
pub mod samples;
pub mod sums;
