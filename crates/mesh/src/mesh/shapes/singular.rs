//! Singular and one-sided surfaces.

use std::f64::consts::{PI, TAU};

use super::assemble::{Join, build, sheet};
use crate::mesh::TriMesh;

/// Builds two tetrahedra with one common edge.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::mesh::shapes::tetrahedra_sharing_edge().positions().len(), 6);
/// ```
pub fn tetrahedra_sharing_edge() -> TriMesh {
    let points = [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
    build(points, tetrahedron_faces([0, 2, 3, 1]).into_iter().chain(tetrahedron_faces([0, 4, 5, 1])).collect())
}

/// Builds two tetrahedra with one common vertex.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::mesh::shapes::tetrahedra_sharing_vertex().positions().len(), 7);
/// ```
pub fn tetrahedra_sharing_vertex() -> TriMesh {
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let points = [[0.0; 3]].into_iter().chain(unit).chain(unit.map(|p| p.map(|x: f64| -x)));
    build(points, tetrahedron_faces([0, 1, 2, 3]).into_iter().chain(tetrahedron_faces([0, 5, 4, 6])).collect())
}

fn tetrahedron_faces([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 4] {
    [[a, c, b], [a, b, d], [b, c, d], [c, a, d]]
}

/// Builds a Moebius strip of n_around x n_across quads.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::mesh::shapes::moebius_strip(20, 3).faces().len(), 120);
/// ```
pub fn moebius_strip(n_around: u32, n_across: u32) -> TriMesh {
    sheet([n_around, n_across], [Join::Twisted, Join::Open], |u, v| {
        let (across, half) = (0.6 * (v - 0.5), PI * u);
        let r = 1.0 + across * half.cos();
        [r * (TAU * u).cos(), r * (TAU * u).sin(), across * half.sin()]
    })
}

/// Builds a Klein bottle of n_around x n_tube quads.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::mesh::shapes::klein_bottle(20, 8).faces().len(), 320);
/// ```
pub fn klein_bottle(n_around: u32, n_tube: u32) -> TriMesh {
    sheet([n_around, n_tube], [Join::Twisted, Join::Round], |u, v| {
        let (half, tube) = (PI * u, TAU * v);
        let r = 2.0 + half.cos() * tube.sin() - half.sin() * (2.0 * tube).sin();
        let z = half.sin() * tube.sin() + half.cos() * (2.0 * tube).sin();
        [r * (TAU * u).cos(), r * (TAU * u).sin(), z]
    })
}
