//! The volume that a mesh encloses.

use glam::DVec3;

use super::surface::triangles;
use crate::geometry::triangle::area_normal_f64;
use crate::mesh::{Topology, TriMesh};

/// The volume inside, in cubes of the mesh's unit, negative where faces look inward; `None` where the mesh, whose topology
/// is given, has a border or faces that disagree on the side.
///
/// ```
/// use neural_mesh::{mesh::{shapes, topology}, metrics::volume};
/// let cuboid = shapes::cuboid([1.0, 2.0, 3.0], 2);
/// assert!((volume(&cuboid, &topology(&cuboid)).unwrap() - 6.0).abs() < 1e-6);
/// let open = shapes::grid(3, 3);
/// assert_eq!(volume(&open, &topology(&open)), None);
/// ```
pub fn volume(mesh: &TriMesh, topology: &Topology) -> Option<f64> {
    if !topology.closed || topology.inconsistent_edges > 0 {
        return None;
    }
    // Corners are taken from the first one, so that far-away coordinates lose nothing.
    let origin = DVec3::from_array(mesh.positions()[mesh.faces()[0][0] as usize].map(f64::from));
    let under = |corners: [[f32; 3]; 3]| {
        let corners = corners.map(|corner| DVec3::from_array(corner.map(f64::from)) - origin);
        corners[0].dot(area_normal_f64(corners)) / 6.0
    };
    Some(triangles(mesh).into_iter().map(under).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{shapes, topology};

    #[test]
    fn turned_over_it_is_negative_and_moved_it_is_the_same() {
        let sphere = shapes::icosphere(4);
        let volume = |positions, faces| {
            let mesh = TriMesh::new(positions, faces).unwrap();
            super::volume(&mesh, &topology(&mesh)).unwrap()
        };
        let inside = volume(sphere.positions().to_vec(), sphere.faces().to_vec());
        assert!((inside / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
        let over = sphere.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert_eq!(volume(sphere.positions().to_vec(), over), -inside);
        let far = sphere.positions().iter().map(|p| p.map(|x| x + 1024.0)).collect();
        assert!((volume(far, sphere.faces().to_vec()) - inside).abs() < 1e-3);
    }
}
