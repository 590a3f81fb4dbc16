//! Several closed components in one mesh.

use super::assemble::{map_points, unite};
use super::solid::{cuboid, icosphere, torus};
use crate::mesh::TriMesh;

/// Builds two unit spheres that touch in one point.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::mesh::shapes::touching_spheres(1).positions().len(), 84);
/// ```
pub fn touching_spheres(level: u32) -> TriMesh {
    let sphere = icosphere(level);
    let at = sphere.positions()[0].map(f64::from);
    let other = map_points(&sphere, true, |p| std::array::from_fn(|k| 2.0 * at[k] - p[k]));
    unite([sphere, other])
}

/// Builds a chain of `n` tori that do not touch.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::mesh::shapes::chain_of_tori(3).faces().len(), 3 * 2048);
/// ```
pub fn chain_of_tori(n: u32) -> TriMesh {
    let link = torus(64, 16, 1.0, 0.25);
    let place = |i: u32| {
        let turned = i % 2 == 1;
        let turn = move |[x, y, z]: [f64; 3]| if turned { [x, -z, y] } else { [x, y, z] };
        map_points(&link, false, move |p| {
            let [x, y, z] = turn(p);
            [x + 1.3 * f64::from(i), y, z]
        })
    };
    unite((0..n).map(place))
}

/// Builds `n` separate boxes with edge lengths from 0.01 to 0.9.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::mesh::shapes::many_boxes(94).faces().len(), 94 * 12);
/// ```
pub fn many_boxes(n: u32) -> TriMesh {
    let place = |i: u32| {
        let length = |k: u32| 0.9 * 0.01f64.powf(f64::from((i * 7 + k * 3) % 10) / 9.0).max(0.01 / 0.9);
        let corner = [f64::from(i % 10), f64::from(i / 10), 0.0];
        map_points(&cuboid([length(0), length(1), length(2)], 1), false, move |p| {
            std::array::from_fn(|k| p[k] + corner[k])
        })
    };
    unite((0..n).map(place))
}
