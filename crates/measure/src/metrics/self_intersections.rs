//! Faces of a mesh that intersect other faces.

use rayon::prelude::*;

use super::search_budget::{affordable_count, run_within_budget};
use super::surface::triangles;
use crate::geometry::crossing::triangles_cross;
use crate::mesh::TriMesh;
use crate::spatial::NearestOnTriangles;

/// Largest number of face pairs tested: a fixed number, plus a number per face.
const MAX_PAIRS: [u64; 2] = [20_000_000, 100];

/// Returns the faces that intersect another face ([`triangles_cross`]), ascending.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::shapes, metrics::self_intersecting_faces};
/// assert!(self_intersecting_faces(&shapes::torus(16, 8, 1.0, 0.3)).is_empty());
/// assert!(!self_intersecting_faces(&shapes::klein_bottle(16, 8)).is_empty());
/// ```
pub fn self_intersecting_faces(mesh: &TriMesh) -> Vec<u32> {
    find_crossing(mesh, u64::MAX).unwrap_or_default()
}

pub(super) fn n_self_intersecting_faces(mesh: &TriMesh) -> Option<usize> {
    let most = MAX_PAIRS[0] + MAX_PAIRS[1] * mesh.faces().len() as u64;
    find_crossing(mesh, most).map(|faces| faces.len())
}

fn find_crossing(mesh: &TriMesh, most: u64) -> Option<Vec<u32>> {
    let triangles = triangles(mesh);
    let tree = NearestOnTriangles::new(&triangles);
    let n_near = |face: usize| {
        let mut n = 0;
        tree.visit_touching(&triangles[face], |_| n += 1);
        n
    };
    if affordable_count(triangles.len(), most as f64, n_near) < triangles.len() {
        return None;
    }
    let crossed_later = |face: usize| {
        let (mut others, mut n_near) = (Vec::new(), 0);
        tree.visit_touching(&triangles[face], |other| {
            n_near += 1;
            others.extend((other as usize > face).then_some(other));
        });
        others.sort_unstable();
        others.dedup();
        others.retain(|&other| triangles_cross(triangles[face], triangles[other as usize]));
        if !others.is_empty() {
            others.push(face as u32);
        }
        (others, n_near)
    };
    let mut faces: Vec<u32> = run_within_budget(triangles.len(), most, crossed_later)?.into_iter().flatten().collect();
    faces.par_sort_unstable();
    faces.dedup();
    Some(faces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn unite(a: &TriMesh, b: &TriMesh, shift: f32) -> TriMesh {
        shapes::unite([a, &shapes::place(b, |[x, y, z]| [x + shift, y, z])])
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
        assert_eq!(self_intersecting_faces(&unite(&cube, &cube, 3.0)), [0u32; 0]);
    }

    #[test]
    fn spheres_that_pass_through_each_other_cross_along_a_circle_of_faces() {
        let sphere = shapes::icosphere(3);
        let both = unite(&sphere, &sphere, 1.0);
        let faces = self_intersecting_faces(&both);
        let near_circle = |&face: &u32| {
            both.faces()[face as usize].iter().any(|&v| (both.positions()[v as usize][0] - 0.5).abs() < 0.2)
        };
        assert!((60..300).contains(&faces.len()) && faces.iter().all(near_circle), "{}", faces.len());
    }

    #[test]
    fn the_same_surface_twice_crosses_everywhere() {
        let cube = shapes::cuboid([1.0; 3], 1);
        assert_eq!(self_intersecting_faces(&unite(&cube, &cube, 0.0)).len(), 24);
    }

    #[test]
    fn too_many_pairs_are_not_tested() {
        let sphere = shapes::icosphere(3);
        let both = unite(&sphere, &sphere, 1.0);
        assert_eq!(n_self_intersecting_faces(&both), Some(self_intersecting_faces(&both).len()));
        assert_eq!(find_crossing(&both, 10_000), None);
    }
}
