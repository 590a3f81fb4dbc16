//! What follows the collapse: flips, fit, parts that would poke through others, foldover repair, and what rounding to the numbers of the file
//! does: faces without area, positions that coincide.

pub mod duplicate_positions;
mod facets;
mod far_points;
pub mod fit;
pub mod flips;
pub mod foldovers;
pub mod nested;
pub mod points;
mod strays;
pub mod without_area;
