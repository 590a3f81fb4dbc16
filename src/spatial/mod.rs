//! Nearest points: k-nn over points and what follows from it, nearest point on triangles; knows no meshes.

mod knn;
mod nearest_on_triangles;
mod point_curvature;
mod triangle_pieces;
mod triangle_tree;

pub use knn::{coherent_order, nearest_neighbours, nearest_to};
pub use nearest_on_triangles::{Hit, NearestOnTriangles};
pub use point_curvature::point_curvature;
pub use triangle_tree::Bounds;
