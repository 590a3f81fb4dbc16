//! What follows the collapse: diagonals, positions, foldovers, and positions that coincide.

pub(super) mod diamond;
pub(super) mod duplicate_positions;
pub(super) mod faces_around;
pub(super) mod facets;
pub(super) mod fit;
pub(super) mod flips;
pub(super) mod foldovers;
pub(super) mod points;
