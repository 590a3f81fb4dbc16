//! Steps after the collapse: flips, fit, nested components, foldover repair, and repair of rounding.

pub mod degenerate_faces;
pub mod duplicate_positions;
mod facets;
mod far_points;
pub mod fit;
pub mod flips;
pub mod foldovers;
pub mod nested;
pub mod sample_points;
pub mod spikes;
mod strays;
