//! Nearest points: k-nn over points, nearest point on triangles; knows no meshes.

mod knn;
mod nearest_on_triangles;
mod triangle_pieces;
mod triangle_tree;

pub use knn::{coherent_order, nearest_neighbours, nearest_to};
pub use nearest_on_triangles::{Hit, NearestOnTriangles};
pub use triangle_tree::Bounds;
