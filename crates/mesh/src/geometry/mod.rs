//! Points, triangles and quadrics as coordinates.

pub mod crossing;
mod eigenvalues;
mod extent;
pub mod line_on_triangle;
pub mod nearest_on_triangle;
pub mod polygon;
mod polygon_grid;
pub mod quadric;
pub mod side_lengths;
pub mod triangle;

pub use eigenvalues::eigenvalues;
#[doc(hidden)]
pub use extent::extent;
pub use quadric::Quadric;
