//! Shapes with boundaries.

use std::f64::consts::TAU;

use super::assemble::{Join, sheet};
use crate::mesh::TriMesh;

/// Builds the unit square as n_x x n_y quads (at least 3 each), facing up.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::mesh::shapes::grid(4, 3).positions().len(), 20);
/// ```
pub fn grid(n_x: u32, n_y: u32) -> TriMesh {
    sheet([n_x, n_y], [Join::Open, Join::Open], |u, v| [u, v, 0.0])
}

/// Builds the side of a cylinder as n_around x n_up quads, facing outward.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::mesh::shapes::open_cylinder(12, 3).faces().len(), 72);
/// ```
pub fn open_cylinder(n_around: u32, n_up: u32) -> TriMesh {
    sheet([n_around, n_up], [Join::Round, Join::Open], |u, v| [(TAU * u).cos(), (TAU * u).sin(), 2.0 * v])
}
