//! Tests of the measures themselves, on whole and random meshes.

use crate::common::{assert_close, assert_same_topology, repeated_positions, uneven_closed_mesh};
use neural_mesh::mesh::{TriMesh, shapes, topology};
use neural_mesh::metrics::{Surface, self_intersecting_faces, turned_faces};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn random_meshes_are_what_tests_take_them_for(mesh in uneven_closed_mesh()) {
        // Vertices may share a position: repeated splits of one edge exhaust the precision.
        let found = topology(&mesh);
        prop_assert!(found.is_closed_manifold() && found.unreferenced_vertices == 0, "{found:?}");
        // A triangle with an angle below 1e-5 counts as its edges, at most a quarter of its height away.
        assert_close(&mesh, &mesh, 2.5e-6);
        assert_same_topology(&mesh, &mesh);
        prop_assert_eq!(turned_faces(&Surface::new(&mesh, 1, 0), &mesh), Vec::<u32>::new());
    }

    #[test]
    fn topology_does_not_depend_on_names_and_order(mesh in uneven_closed_mesh(), step in 1usize..1000) {
        let n = mesh.positions().len() as u32;
        let renamed = |v: u32| n - 1 - v;
        let positions = mesh.positions().iter().rev().copied().collect();
        let mut faces: Vec<_> = mesh.faces().iter().map(|&[a, b, c]| [b, c, a].map(renamed)).collect();
        let shift = step % faces.len();
        faces.rotate_left(shift);
        prop_assert_eq!(topology(&mesh), topology(&TriMesh::new(positions, faces).unwrap()));
    }

    #[test]
    fn a_missing_face_leaves_one_hole(mesh in uneven_closed_mesh(), which in 0usize..10_000) {
        let mut faces = mesh.faces().to_vec();
        faces.remove(which % mesh.faces().len());
        let holed = topology(&TriMesh::new(mesh.positions().to_vec(), faces).unwrap());
        prop_assert_eq!((holed.boundary_edges, holed.boundary_loops), (3, 1));
        prop_assert_eq!(holed.genus, topology(&mesh).genus);
    }
}

#[test]
#[should_panic(expected = "of the diagonal apart")]
fn a_coarse_sphere_is_not_close() {
    assert_close(&shapes::icosphere(4), &shapes::icosphere(0), 0.01);
}

#[test]
fn crossing_faces_are_those_of_the_naive_search() {
    use neural_mesh::geometry::crossing::triangles_cross;
    let mesh = shapes::klein_bottle(24, 12);
    let corners = |face: usize| mesh.faces()[face].map(|v| mesh.positions()[v as usize]);
    let n = mesh.faces().len();
    let crosses = |&i: &usize| (0..n).any(|j| i != j && triangles_cross(corners(i), corners(j)));
    let naive: Vec<u32> = (0..n).filter(crosses).map(|i| i as u32).collect();
    assert_eq!(self_intersecting_faces(&mesh), naive);
}

#[test]
fn vertices_at_one_position_are_no_trouble_of_the_topology() {
    // An octahedron is pressed flat.
    let positions = vec![[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0; 3], [0.0; 3]];
    let upper = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4]];
    let faces = upper.into_iter().chain(upper.map(|[a, b, _]| [b, a, 5])).collect();
    let flat = TriMesh::new(positions, faces).unwrap();
    assert!(topology(&flat).is_closed_manifold());
    assert_eq!(repeated_positions(&flat), 1);
    assert_close(&flat, &flat, 1e-9);
}
