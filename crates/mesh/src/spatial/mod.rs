//! Spatial searches: closest points, nearest neighbours, rays and views.

mod bounds;
mod curve_order;
mod exposure;
mod face_tree;
mod farthest_points;
mod knn;
mod near_row;
mod nearest_along_line;
mod nearest_on_triangles;
mod needle_tree;
mod occluders;
mod parallel_views;
mod point_curvature;
mod point_grid;
mod triangle_pieces;
mod triangle_tree;

pub use bounds::Bounds;
#[doc(hidden)]
pub use curve_order::curve_order;
pub use exposure::{Exposure, Labels, exposures};
pub use face_tree::{FaceTree, SearchCost};
pub use farthest_points::{farthest_latent_points, farthest_points};
pub use knn::{coherent_order, nearest_neighbours, nearest_to};
pub use nearest_on_triangles::{Hit, NearestOnTriangles};
pub use occluders::Occluders;
pub use parallel_views::{visible_areas, visible_faces};
pub use point_curvature::point_curvature;
pub use point_grid::PointGrid;
