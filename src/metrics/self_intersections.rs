//! Faces of a mesh that pass through other faces of it.

use rayon::prelude::*;

use super::surface::triangles;
use crate::geometry::crossing::triangles_cross;
use crate::mesh::TriMesh;
use crate::spatial::{Bounds, NearestOnTriangles};

/// The faces that cross another face, in order; neighbours count only where they share more than corners and edges.
///
/// See [`triangles_cross`] for what crossing is.
///
/// ```
/// use neural_mesh::{mesh::shapes, metrics::self_intersecting_faces};
/// assert!(self_intersecting_faces(&shapes::torus(16, 8, 1.0, 0.3)).is_empty());
/// assert!(!self_intersecting_faces(&shapes::klein_bottle(16, 8)).is_empty());
/// ```
pub fn self_intersecting_faces(mesh: &TriMesh) -> Vec<u32> {
    let triangles = triangles(mesh);
    let tree = NearestOnTriangles::new(&triangles);
    let crossed_later = |face: u32| {
        let corners = triangles[face as usize];
        let mut others = Vec::new();
        tree.visit_overlaps(&Bounds::of(&corners), |other| others.extend((other > face).then_some(other)));
        others.sort_unstable();
        others.dedup();
        others.retain(|&other| triangles_cross(corners, triangles[other as usize]));
        if !others.is_empty() {
            others.push(face);
        }
        others
    };
    let mut faces: Vec<u32> = (0..triangles.len() as u32).into_par_iter().flat_map_iter(crossed_later).collect();
    faces.par_sort_unstable();
    faces.dedup();
    faces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn united(a: &TriMesh, b: &TriMesh, shift: f32) -> TriMesh {
        let n = a.positions().len() as u32;
        let moved = b.positions().iter().map(|&[x, y, z]| [x + shift, y, z]);
        let faces = a.faces().iter().copied().chain(b.faces().iter().map(|face| face.map(|v| v + n)));
        TriMesh::new(a.positions().iter().copied().chain(moved).collect(), faces.collect()).unwrap()
    }

    #[test]
    fn clean_shapes_have_none_also_where_parts_touch() {
        for mesh in [shapes::icosphere(3), shapes::plate(6, 0.01), shapes::bolt(24), shapes::thin_sheet(20, 1e-3)] {
            assert_eq!(self_intersecting_faces(&mesh), [0u32; 0]);
        }
        for mesh in [shapes::chain_of_tori(3), shapes::many_boxes(30), shapes::touching_spheres(2)] {
            assert_eq!(self_intersecting_faces(&mesh), [0u32; 0]);
        }
        let cube = shapes::cuboid([1.0; 3], 2);
        assert_eq!(self_intersecting_faces(&united(&cube, &cube, 3.0)), [0u32; 0]);
    }

    #[test]
    fn spheres_that_pass_through_each_other_cross_along_a_circle_of_faces() {
        let sphere = shapes::icosphere(3);
        let both = united(&sphere, &sphere, 1.0);
        let faces = self_intersecting_faces(&both);
        let near_circle = |&face: &u32| {
            both.faces()[face as usize].iter().any(|&v| (both.positions()[v as usize][0] - 0.5).abs() < 0.2)
        };
        assert!((60..300).contains(&faces.len()) && faces.iter().all(near_circle), "{}", faces.len());
    }

    #[test]
    fn the_same_surface_twice_crosses_everywhere() {
        let cube = shapes::cuboid([1.0; 3], 1);
        assert_eq!(self_intersecting_faces(&united(&cube, &cube, 0.0)).len(), 24);
    }
}
