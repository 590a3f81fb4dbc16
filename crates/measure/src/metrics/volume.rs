//! Volume enclosed by a mesh.

use glam::{DVec3, Vec3};

use super::surface::triangles;
use crate::geometry::triangle::area_normal_f64;
use crate::mesh::{TriMesh, edges};

/// Returns the enclosed volume, negative if faces face inward; `None` without one.
///
/// Faces enclose a volume if every edge has as many faces in one direction as in the other.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::shapes, metrics::volume};
/// assert!((volume(&shapes::cuboid([1.0, 2.0, 3.0], 2)).unwrap() - 6.0).abs() < 1e-6);
/// assert_eq!(volume(&shapes::grid(3, 3)), None);
/// ```
pub fn volume(mesh: &TriMesh) -> Option<f64> {
    if mesh.faces().is_empty() || edges(mesh).iter().any(|edge| edge.up != edge.down) {
        return None;
    }
    // Relative to the first corner, so that far-away coordinates lose no precision.
    let origin = DVec3::from_array(mesh.positions()[mesh.faces()[0][0] as usize].map(f64::from));
    let under = |corners: [[f32; 3]; 3]| {
        let corners = corners.map(|corner| Vec3::from(corner).as_dvec3() - origin);
        corners[0].dot(area_normal_f64(corners)) / 6.0
    };
    Some(triangles(mesh).into_iter().map(under).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn turned_over_it_is_negative_and_moved_it_is_the_same() {
        let sphere = shapes::icosphere(4);
        let volume = |positions, faces| super::volume(&TriMesh::new(positions, faces).unwrap()).unwrap();
        let inside = volume(sphere.positions().to_vec(), sphere.faces().to_vec());
        assert!((inside / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
        let over = sphere.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert_eq!(volume(sphere.positions().to_vec(), over), -inside);
        let far = sphere.positions().iter().map(|p| p.map(|x| x + 1024.0)).collect();
        assert!((volume(far, sphere.faces().to_vec()) - inside).abs() < 1e-3);
    }

    #[test]
    fn bodies_that_share_an_edge_have_a_volume_and_bodies_with_a_fin_have_none() {
        let pair = shapes::tetrahedra_sharing_edge();
        let each = volume(&shapes::tetrahedron()).unwrap();
        assert!(each > 0.0 && volume(&pair).is_some());
        let mut faces = shapes::tetrahedron().faces().to_vec();
        let mut positions = shapes::tetrahedron().positions().to_vec();
        positions.push([9.0; 3]);
        faces.push([0, 1, 4]);
        let fin = TriMesh::new(positions.clone(), faces.clone()).unwrap();
        assert_eq!(volume(&fin), None);
        // Closed by a flipped copy, the fin encloses nothing and changes nothing.
        faces.push([1, 0, 4]);
        let folded = TriMesh::new(positions, faces).unwrap();
        assert!((volume(&folded).unwrap() - each).abs() < 1e-6);
    }
}
